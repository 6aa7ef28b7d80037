// SPDX-License-Identifier: MIT
/*
 * Two views of one scene in three.js, side by side or one above the other: left
 * lit by a baked set, with the reflections of `iblbake --explain`, right by what
 * three.js prefilters itself.
 */
import * as THREE from './three/build/three.module.js';
import {OrbitControls} from './three/examples/jsm/controls/OrbitControls.js';
import {DRACOLoader} from './three/examples/jsm/loaders/DRACOLoader.js';
import {GLTFLoader} from './three/examples/jsm/loaders/GLTFLoader.js';
import {KTX2Loader} from './three/examples/jsm/loaders/KTX2Loader.js';
import {MeshoptDecoder} from
    './three/examples/jsm/libs/meshopt_decoder.module.js';
import {clone} from './three/examples/jsm/utils/SkeletonUtils.js';
import reflections from './reflections.js';

export const ROUGHNESS = [0.1, 0.3, 0.5, 0.7, 0.9];
export const MATERIALS = [
    {name: 'Silver', metal: 1, colour: [0.95, 0.94, 0.92]},
    {name: 'Gold', metal: 1, colour: [1, 0.71, 0.29]},
    {name: 'Plastic', metal: 0, colour: [0.7, 0.72, 0.75]}];
export const MEASURED = 512; // pixels across a sphere
const LIBS = './three/examples/jsm/libs/';

/* The program's lines replace chunks of shaders: here of one side's materials. */
const chunks = {...THREE.ShaderChunk};
reflections({ShaderChunk: chunks});
function fit(material) {
    material.onBeforeCompile = shader => {
        for (const name of ['lights_fragment_maps',
                            'envmap_physical_pars_fragment'])
            shader.fragmentShader = shader.fragmentShader.replace(
                `#include <${name}>`, () => chunks[name]);
    };
    material.customProgramCacheKey = () => 'ibl_lobe_fit';
    return material;
}

/* Levels of half floats of a KTX2 file, which no loader of three.js takes. */
function halfFloats({buffer, byteOffset, byteLength}) {
    const view = new DataView(buffer, byteOffset, byteLength), faces = [];
    const size = view.getUint32(20, true), count = view.getUint32(40, true);
    for (let face = 0; face < 6; face++)
        faces.push({width: size, height: size, mipmaps: []});
    for (let l = 0; l < count; l++) {
        const at = Number(view.getBigUint64(80 + 24 * l, true)), n = size >> l;
        faces.forEach(({mipmaps}, face) => mipmaps.push({width: n, height: n,
            data: new Uint16Array(buffer, byteOffset + at + face * n * n * 8,
                                  n * n * 4)}));
    }
    const map = new THREE.CompressedCubeTexture(faces, THREE.RGBAFormat,
                                                THREE.HalfFloatType);
    map.minFilter = THREE.LinearMipmapLinearFilter;
    map.needsUpdate = true;
    return map;
}

export function createView(canvas, picked, turned) {
    const renderer = new THREE.WebGLRenderer({canvas, antialias: true});
    renderer.toneMapping = THREE.NeutralToneMapping;
    renderer.setScissorTest(true);
    const ktx2 = new KTX2Loader().setTranscoderPath(LIBS + 'basis/')
        .detectSupport(renderer);
    const camera = new THREE.PerspectiveCamera(24, 1, 0.1, 100);
    const orbit = new OrbitControls(camera, canvas);
    orbit.enabled = orbit.enablePan = false;
    orbit.addEventListener('change', draw);
    const round = new THREE.SphereGeometry(1, 96, 64);
    const sides = [fit, x => x].map(own => {
        const scene = new THREE.Scene(), balls = new THREE.Group();
        MATERIALS.forEach(({metal, colour}, row) => ROUGHNESS.forEach(
            (roughness, column) => {
                const ball = new THREE.Mesh(round, own(
                    new THREE.MeshStandardMaterial({roughness, metalness: metal,
                        color: new THREE.Color(...colour)})));
                ball.userData = {row, column};
                balls.add(ball);
            }));
        scene.add(balls);
        return {scene, balls, own, model: null, rotate: 0, exposure: 0};
    });
    let sight = {exposure: 0, rotation: 0, background: 'blurred'};
    let equirect, pmrem, asked = false, drawn = [], size = [1, 1], tall = false;

    /* ---- drawing ---- */

    function draw() {
        if (!asked)
            requestAnimationFrame(now);
        asked = true;
    }
    function light({scene, rotate, exposure}) {
        scene.environmentRotation.y = scene.backgroundRotation.y =
            (sight.rotation - rotate) * Math.PI / 180;
        scene.environmentIntensity = scene.backgroundIntensity =
            2 ** (sight.exposure - exposure);
    }
    function now() {
        asked = false;
        const [w, h] = size;
        sides.forEach((side, k) => {
            const {scene} = side, half = tall ? [w, h / 2] : [w / 2, h];
            const at = tall ? [0, k ? 0 : h / 2] : [k * w / 2, 0];
            renderer.setViewport(...at, ...half);
            renderer.setScissor(...at, ...half);
            light(side);
            const sharp = sight.background === 'sharp';
            scene.background = !scene.environment || sight.background === 'none' ?
                new THREE.Color(0x14171c) :
                sharp && equirect ? equirect : scene.environment;
            if (sharp && equirect) {
                scene.backgroundRotation.y = sight.rotation * Math.PI / 180;
                scene.backgroundIntensity = 2 ** sight.exposure;
            }
            scene.backgroundBlurriness = sharp ? 0 : 0.45;
            renderer.render(scene, camera);
        });
        drawn.splice(0).forEach(go => go());
    }
    /* Spheres in rows of materials, or of roughness on a high view. */
    function lay() {
        const {clientWidth: w, clientHeight: h} = canvas;
        if (!w || !h)
            return;
        size = [w, h];
        tall = w < 1.1 * h;
        renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
        renderer.setSize(w, h, false);
        camera.aspect = tall ? 2 * w / h : w / 2 / h;
        // As large as they can be below the label.
        const {length: m} = MATERIALS, {length: n} = ROUGHNESS;
        const height = (across, down) =>
            2.3 * Math.max(down + 0.5, across / camera.aspect);
        const upright = height(m, n) < height(n, m);
        for (const {balls} of sides)
            for (const ball of balls.children) {
                const {row, column} = ball.userData;
                const x = column - (n - 1) / 2, y = row - (m - 1) / 2;
                ball.position.set(2.3 * (upright ? y : x),
                                  -2.3 * (upright ? x : y) - 0.4, 0);
            }
        if (!orbit.enabled)
            camera.position.set(0, 0, (upright ? height(m, n) : height(n, m)) /
                2 / Math.tan(camera.fov * Math.PI / 360));
        camera.updateProjectionMatrix();
        draw();
    }
    new ResizeObserver(lay).observe(canvas);

    /* ---- the pointer: a sphere is chosen, or the map turned ---- */

    let down = null;
    canvas.addEventListener('pointerdown', e => {
        down = {x: e.clientX, y: e.clientY, from: sight.rotation, moved: false};
        if (!orbit.enabled)
            canvas.setPointerCapture(e.pointerId);
    });
    canvas.addEventListener('pointermove', e => {
        if (!down || orbit.enabled || Math.abs(e.clientX - down.x) < 4)
            return;
        down.moved = true;
        turned((down.from + (e.clientX - down.x) / 3 + 540) % 360 - 180, false);
    });
    canvas.addEventListener('pointerup', e => {
        if (down?.moved)
            turned(sight.rotation, true);
        else if (down && !orbit.enabled) {
            const box = canvas.getBoundingClientRect();
            const [w, h] = tall ? [box.width, box.height / 2] :
                [box.width / 2, box.height];
            const ray = new THREE.Raycaster();
            ray.setFromCamera(new THREE.Vector2(
                (e.clientX - box.left) % w / w * 2 - 1,
                1 - (e.clientY - box.top) % h / h * 2), camera);
            const [hit] = ray.intersectObjects(sides[0].balls.children);
            if (hit)
                picked(hit.object.userData);
        }
        down = null;
    });

    /* ---- what is lit, and by what ---- */

    const until = () => new Promise(go => {
        drawn.push(go);
        draw();
    });
    function dress(model, own) {
        model.traverse(part => {
            if (part.isMesh)
                part.material = [part.material].flat().map(m => own(m.clone()));
            if (part.material?.length === 1)
                [part.material] = part.material;
        });
        return model;
    }
    return {
        set: s => {
            sight = {...sight, ...s};
            draw();
        },
        /* A specular cube: half floats, or what three.js transcodes. Is done
         * when it is drawn. */
        async show(bytes, half, {rotate = 0, exposure = 0} = {}) {
            const map = half ? halfFloats(bytes) : await new Promise((go, fail) =>
                ktx2.parse(bytes.slice().buffer, go, fail));
            map.isPMREMTexture = true;
            sides[0].scene.environment?.dispose();
            Object.assign(sides[0], {rotate, exposure});
            sides[0].scene.environment = map;
            await until();
        },
        /* The map as three.js takes it; gives the time that it took. */
        async prefilter(map) {
            pmrem?.dispose();
            equirect?.dispose();
            pmrem = equirect = sides[1].scene.environment = null;
            if (!map)
                return draw();
            equirect = new THREE.DataTexture(map.half, map.w, map.h,
                THREE.RGBAFormat, THREE.HalfFloatType,
                THREE.EquirectangularReflectionMapping);
            equirect.magFilter = equirect.minFilter = THREE.LinearFilter;
            equirect.flipY = equirect.needsUpdate = true;
            const start = performance.now();
            const generator = new THREE.PMREMGenerator(renderer);
            pmrem = generator.fromEquirectangular(equirect);
            generator.dispose();
            renderer.readRenderTargetPixels(pmrem, 0, 0, 1, 1,
                                            new Uint16Array(4), 0);
            const took = performance.now() - start;
            sides[1].scene.environment = pmrem.texture;
            await until();
            return took;
        },
        /* Radiance of a sphere that is seen from far away: RGBA of each side. */
        measure({row, column}) {
            const target = new THREE.WebGLRenderTarget(MEASURED, MEASURED,
                {type: THREE.FloatType});
            const far = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.1, 10);
            const index = row * ROUGHNESS.length + column;
            const out = sides.map(side => {
                const {scene, balls} = side, ball = balls.children[index];
                if (!scene.environment)
                    return null;
                const hidden = [balls.visible, scene.background];
                far.position.copy(ball.position).setZ(5);
                balls.children.forEach(b => b.visible = b === ball);
                balls.visible = true;
                scene.background = null;
                if (side.model)
                    side.model.visible = false;
                light(side);
                scene.environmentIntensity = 2 ** -side.exposure;
                renderer.setRenderTarget(target);
                renderer.setScissorTest(false);
                renderer.render(scene, far);
                const pixels = new Float32Array(4 * MEASURED * MEASURED);
                renderer.readRenderTargetPixels(target, 0, 0, MEASURED, MEASURED,
                                                pixels);
                renderer.setRenderTarget(null);
                renderer.setScissorTest(true);
                balls.children.forEach(b => b.visible = true);
                [balls.visible, scene.background] = hidden;
                if (side.model)
                    side.model.visible = true;
                return pixels;
            });
            target.dispose();
            draw();
            return out;
        },
        /* A model of glTF of some files, by name; nothing: spheres again. */
        async model(files) {
            let loaded = null;
            if (files) {
                const urls = new Map([...files].map(file => [file.name,
                    URL.createObjectURL(file)]));
                const manager = new THREE.LoadingManager().setURLModifier(url =>
                    urls.get(decodeURIComponent(url.split('/').pop())) ?? url);
                const main = [...urls.keys()].find(n => /\.gl(b|tf)$/i.test(n));
                loaded = (await new GLTFLoader(manager).setKTX2Loader(ktx2)
                    .setMeshoptDecoder(MeshoptDecoder)
                    .setDRACOLoader(new DRACOLoader(manager)
                        .setDecoderPath(LIBS + 'draco/gltf/'))
                    .loadAsync(urls.get(main))).scene;
                urls.forEach(url => URL.revokeObjectURL(url));
                const box = new THREE.Box3().setFromObject(loaded);
                const scale = 2 / box.getSize(new THREE.Vector3()).length();
                loaded.position.sub(box.getCenter(new THREE.Vector3()))
                    .multiplyScalar(scale);
                loaded.scale.multiplyScalar(scale);
            }
            for (const side of sides) {
                if (side.model)
                    side.scene.remove(side.model);
                side.model = loaded && dress(clone(loaded), side.own);
                if (side.model)
                    side.scene.add(side.model);
                side.balls.visible = !loaded;
            }
            orbit.enabled = !!loaded;
            canvas.style.touchAction = loaded ? 'none' : 'pan-y';
            camera.rotation.set(0, 0, 0);
            if (loaded)
                camera.position.set(0, 1, 6);
            orbit.target.set(0, 0, 0);
            loaded ? orbit.update() : lay();
            draw();
        },
        /* Programs of shaders take their time: those of an empty map. */
        async warm() {
            const map = halfFloats(blank());
            map.isPMREMTexture = true;
            sides[0].scene.environment = map;
            await renderer.compileAsync(sides[0].scene, camera);
        }
    };
}

/* A cube of 1x1 black texels, as a KTX2 file has them. */
function blank() {
    const bytes = new Uint8Array(104 + 48), view = new DataView(bytes.buffer);
    view.setUint32(20, 1, true);
    view.setUint32(40, 1, true);
    view.setBigUint64(80, 104n, true);
    return bytes;
}
