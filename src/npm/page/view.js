// SPDX-License-Identifier: MIT
/*
 * Two views of one scene in three.js, side by side or one above the other: one
 * lit by a baked set, with the reflections of `iblbake --explain`, the other by
 * what three.js prefilters itself.
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
const LIBS = './three/examples/jsm/libs/', DEGREE = Math.PI / 180;

/* The program's lines replace chunks of shaders: here of one side's materials. */
const chunks = {...THREE.ShaderChunk};
reflections({ShaderChunk: chunks});
function fit(material) {
    material.onBeforeCompile = shader => shader.fragmentShader =
        shader.fragmentShader.replace(/#include <(lights_fragment_maps|envmap_physical_pars_fragment)>/g,
                                      (_, name) => chunks[name]);
    material.customProgramCacheKey = () => 'ibl_lobe_fit';
    return material;
}
const ball = ({metal, colour}, roughness) => new THREE.MeshStandardMaterial(
    {roughness, metalness: metal, color: new THREE.Color(...colour)});

/* A cube of half floats, which no loader of three.js takes: texels(level, face,
 * edge). */
function cube(size, count, texels) {
    const faces = [0, 1, 2, 3, 4, 5].map(face => ({width: size, height: size,
        mipmaps: Array.from({length: count}, (_, l) => ({width: size >> l,
            height: size >> l, data: texels(l, face, size >> l)}))}));
    const map = new THREE.CompressedCubeTexture(faces, THREE.RGBAFormat,
                                                THREE.HalfFloatType);
    map.minFilter = THREE.LinearMipmapLinearFilter;
    map.needsUpdate = true;
    return map;
}
function ktx2Cube({buffer, byteOffset, byteLength}) {
    const view = new DataView(buffer, byteOffset, byteLength);
    return cube(view.getUint32(20, true), view.getUint32(40, true),
        (l, face, n) => new Uint16Array(buffer, byteOffset + face * n * n * 8 +
            Number(view.getBigUint64(80 + 24 * l, true)), n * n * 4));
}

/* picked(where): a sphere was; turned(degrees, end): the map was. */
export function createView(canvas, picked, turned) {
    const renderer = new THREE.WebGLRenderer({canvas, antialias: true});
    renderer.toneMapping = THREE.NeutralToneMapping;
    const ktx2 = new KTX2Loader().setTranscoderPath(LIBS + 'basis/')
        .detectSupport(renderer);
    const camera = new THREE.PerspectiveCamera(24, 1, 0.1, 100);
    const orbit = new OrbitControls(camera, canvas);
    orbit.enabled = orbit.enablePan = false;
    orbit.listenToKeyEvents(canvas);
    orbit.addEventListener('change', draw);
    const round = new THREE.SphereGeometry(1, 96, 64);
    const far = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.1, 10);
    far.position.z = 5;
    const sides = [fit, x => x].map(own => {
        const scene = new THREE.Scene(), balls = new THREE.Group();
        MATERIALS.forEach((material, row) => ROUGHNESS.forEach((r, column) => {
            const mesh = new THREE.Mesh(round, own(ball(material, r)));
            mesh.userData = {row, column};
            balls.add(mesh);
        }));
        scene.add(balls);
        const single = new THREE.Scene().add(new THREE.Mesh(round));
        return {scene, single, balls, own, rotate: 0, exposure: 0};
    });
    const sight = {exposure: 0, rotation: 0, background: 'blurred'};
    let equirect, pmrem, asked = false, drawn = [], tall = false;

    function draw() {
        asked ||= requestAnimationFrame(now);
    }
    function now() {
        const {clientWidth: w, clientHeight: h} = canvas;
        asked = false;
        sides.forEach(({scene, rotate, exposure}, k) => {
            const box = tall ? [0, k ? 0 : h / 2, w, h / 2] :
                [k * w / 2, 0, w / 2, h];
            renderer.setViewport(...box);
            renderer.setScissor(...box);
            const sharp = sight.background === 'sharp' && equirect;
            scene.background = !scene.environment || sight.background === 'none' ?
                new THREE.Color(0x14171c) : sharp || scene.environment;
            scene.backgroundBlurriness = sharp ? 0 : 0.45;
            const turn = (sight.rotation - rotate) * DEGREE;
            scene.environmentRotation.y = turn;
            scene.environmentIntensity = 2 ** (sight.exposure - exposure);
            scene.backgroundRotation.y = sharp ? sight.rotation * DEGREE : turn;
            scene.backgroundIntensity = sharp ? 2 ** sight.exposure :
                scene.environmentIntensity;
            renderer.setScissorTest(true);
            renderer.render(scene, camera);
            renderer.setScissorTest(false);
        });
        drawn.splice(0).forEach(go => go());
    }
    const shown = () => new Promise(go => {
        drawn.push(go);
        draw();
    });
    /* Rows of materials, or of roughness: what makes spheres larger. */
    function lay() {
        const {clientWidth: w, clientHeight: h} = canvas;
        if (!w || !h)
            return;
        tall = w < 1.1 * h;
        renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
        renderer.setSize(w, h, false);
        camera.aspect = tall ? 2 * w / h : w / 2 / h;
        const {length: m} = MATERIALS, {length: n} = ROUGHNESS;
        const rows = tall ? h / 2 : h, label = 40; // in pixels
        const height = (across, down) =>
            2.3 * Math.max(down / (1 - label / rows), across / camera.aspect);
        const upright = height(m, n) < height(n, m);
        const all = Math.min(height(m, n), height(n, m));
        sides.forEach(({balls}) => balls.children.forEach(({position, userData}) => {
            const x = 2.3 * (userData.column - (n - 1) / 2);
            const y = 2.3 * (userData.row - (m - 1) / 2);
            position.set(upright ? y : x, (upright ? -x : -y) - all * label / 2 / rows, 0);
        }));
        if (!orbit.enabled)
            camera.position.set(0, 0,
                all / 2 / Math.tan(camera.fov / 2 * DEGREE));
        camera.updateProjectionMatrix();
        draw();
    }
    new ResizeObserver(lay).observe(canvas);

    let down = null;
    canvas.onpointerdown = e => {
        if (!orbit.enabled)
            canvas.setPointerCapture(e.pointerId);
        down = orbit.enabled ? null : {x: e.clientX, from: sight.rotation};
    };
    canvas.onpointermove = e => {
        const by = down ? e.clientX - down.x : 0;
        if (down?.moved || Math.abs(by) > 4) {
            down.moved = true;
            turned((down.from + by / 3 + 540) % 360 - 180, false);
        }
    };
    canvas.onpointercancel = () => down = null;
    canvas.onpointerup = e => {
        const {clientWidth: w, clientHeight: h} = canvas;
        if (down?.moved)
            turned(sight.rotation, true);
        else if (down) {
            const ray = new THREE.Raycaster(), part = x => x % 1 * 2 - 1;
            ray.setFromCamera(new THREE.Vector2(
                part(e.offsetX / w * (tall ? 1 : 2)),
                -part(e.offsetY / h * (tall ? 2 : 1))), camera);
            const [hit] = ray.intersectObjects(sides[0].balls.children);
            hit && picked(hit.object.userData);
        }
        down = null;
    };

    return {
        set(s) {
            Object.assign(sight, s);
            draw();
        },
        /* Shaders take their time: those of an empty map, before there is one. */
        warm() {
            const map = cube(1, 1, () => new Uint16Array(4));
            map.isPMREMTexture = true;
            sides[0].scene.environment = map;
            return shown();
        },
        /* A specular cube: half floats, or what three.js transcodes. Is done
         * when it is drawn. */
        async show(bytes, half, {rotate = 0, exposure = 0}) {
            const map = half ? ktx2Cube(bytes) : await new Promise((go, fail) =>
                ktx2.parse(bytes.slice().buffer, go, fail));
            map.isPMREMTexture = true;
            sides[0].scene.environment?.dispose();
            Object.assign(sides[0], {rotate, exposure});
            sides[0].scene.environment = map;
            await shown();
        },
        /* A map as three.js takes it, or none; gives the time that it took. */
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
            await shown();
            return took;
        },
        /* Radiance of a sphere that is seen from far away: RGBA of each side. */
        measure({row, column}) {
            const target = new THREE.WebGLRenderTarget(MEASURED, MEASURED,
                {type: THREE.FloatType});
            const out = sides.map(({scene, single, own, rotate, exposure}) => {
                if (!scene.environment)
                    return null;
                const pixels = new Float32Array(4 * MEASURED * MEASURED);
                single.environment = scene.environment;
                single.environmentRotation.y = (sight.rotation - rotate) * DEGREE;
                single.environmentIntensity = 2 ** -exposure;
                single.children[0].material.dispose();
                single.children[0].material =
                    own(ball(MATERIALS[row], ROUGHNESS[column]));
                renderer.setRenderTarget(target);
                renderer.render(single, far);
                renderer.readRenderTargetPixels(target, 0, 0, MEASURED, MEASURED,
                                                pixels);
                renderer.setRenderTarget(null);
                return pixels;
            });
            target.dispose();
            return out;
        },
        /* A model of glTF of some files, by name; nothing: spheres again. */
        async model(files) {
            let loaded;
            if (files) {
                const urls = Object.fromEntries(files.map(file =>
                    [file.name, URL.createObjectURL(file)]));
                const manager = new THREE.LoadingManager().setURLModifier(url =>
                    urls[decodeURIComponent(url.split('/').pop())] ?? url);
                loaded = (await new GLTFLoader(manager).setKTX2Loader(ktx2)
                    .setMeshoptDecoder(MeshoptDecoder)
                    .setDRACOLoader(new DRACOLoader(manager)
                        .setDecoderPath(LIBS + 'draco/gltf/'))
                    .loadAsync(Object.keys(urls).find(n => /\.gl(b|tf)$/i.test(n))))
                    .scene;
                const box = new THREE.Box3().setFromObject(loaded);
                const scale = 2 / box.getSize(new THREE.Vector3()).length();
                loaded.position.sub(box.getCenter(new THREE.Vector3()))
                    .multiplyScalar(scale);
                loaded.scale.multiplyScalar(scale);
            }
            for (const side of sides) {
                if (side.model)
                    side.scene.remove(side.model);
                side.model = loaded && clone(loaded);
                side.model?.traverse(part => part.material &&=
                    Array.isArray(part.material) ? part.material :
                        side.own(part.material.clone()));
                if (side.model)
                    side.scene.add(side.model);
                side.balls.visible = !loaded;
            }
            orbit.enabled = !!loaded;
            canvas.style.touchAction = loaded ? 'none' : 'pan-y';
            orbit.target.set(0, 0, 0);
            camera.position.set(0, loaded ? 1 : 0, 6);
            orbit.update();
            lay();
        }
    };
}
