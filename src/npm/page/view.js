// SPDX-License-Identifier: MIT
/*
 * A scene in three.js, twice side by side: lit by a baked set, with the reflections
 * of `iblbake --explain`, and by what three.js prefilters itself. The truth about a
 * sphere is the same shader with a sum over the pixels of the map.
 */
import * as THREE from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {EXRLoader} from 'three/addons/loaders/EXRLoader.js';
import {GLTFLoader} from 'three/addons/loaders/GLTFLoader.js';
import {HDRLoader} from 'three/addons/loaders/HDRLoader.js';
import reflections from './reflections.js';

const ROUGHNESS = [0.1, 0.3, 0.5, 0.7, 0.9], MATERIALS = [ // silver, gold, plastic
    {metalness: 1, color: new THREE.Color(0.95, 0.94, 0.92)},
    {metalness: 1, color: new THREE.Color(1, 0.71, 0.29)},
    {metalness: 0, color: new THREE.Color(0.7, 0.72, 0.75)}];
export const PIXELS = 64; // across a sphere that is measured
const DEGREE = Math.PI / 180;

/* Light of an environment is looked up by the program's lines or by those of
 * three.js, or summed over some of the map's patches. */
const MAPS = 'lights_fragment_maps', PARS = 'envmap_physical_pars_fragment';
const chunks = {...THREE.ShaderChunk};
reflections({ShaderChunk: chunks});
const LOOKUP = `if (baked) {\n${chunks[MAPS]}\n} else {\n${THREE.ShaderChunk[MAPS]}\n}`;
const SUM = `
vec3 reflected = vec3(0.0);
for (int j = rows.x; j < rows.y; j++)
    for (int i = 0; i < textureSize(patches, 0).x; i += 2) {
        vec3 to = normalize(texelFetch(patches, ivec2(i, j), 0).xyz);
        float cosine = dot(to, geometryNormal);
        if (cosine <= 0.0)
            continue;
        vec3 light = cosine * texelFetch(patches, ivec2(i + 1, j), 0).rgb;
        iblIrradiance += light;
        reflected += light * BRDF_GGX(to, geometryViewDir, geometryNormal, material);
    }
radiance += reflected / (material.specularColorBlended * material.dfg.x +
    material.specularF90 * material.dfg.y);`;
const uniforms = {baked: {}, patches: {}, rows: {value: new THREE.Vector2()}};
function fit(material, lines = LOOKUP) {
    material.onBeforeCompile = shader => {
        Object.assign(shader.uniforms, uniforms);
        shader.fragmentShader = `uniform bool baked; uniform ivec2 rows;
            uniform highp sampler2D patches;\n` + shader.fragmentShader
            .replace(`#include <${PARS}>`, () => chunks[PARS])
            .replace(`#include <${MAPS}>`, () => lines);
    };
    material.customProgramCacheKey = () => lines;
    return material;
}

/* A cube of half floats, which no loader of three.js takes: texels(level, face,
 * edge). */
function cube(size, count, texels) {
    const faces = [0, 1, 2, 3, 4, 5].map(face => ({width: size, height: size,
        mipmaps: Array.from({length: count}, (_, level) => size >> level).map((n, level) =>
            ({width: n, height: n, data: texels(level, face, n)}))}));
    const map = new THREE.CompressedCubeTexture(faces, THREE.RGBAFormat, THREE.HalfFloatType);
    map.minFilter = THREE.LinearMipmapLinearFilter;
    map.needsUpdate = map.isPMREMTexture = true;
    return map;
}
const dark = levels => cube(2 ** (levels - 1), levels, (l, face, n) => new Uint16Array(4 * n * n));

/* A map as patches of the sky, not wider than that: pairs of texels with the direction
 * of the light's middle, so that what is left out is of second order, and radiance
 * times area. Pixels are split where they are wider. */
function patchesOf({flipY, image: {width, height, data}}, widest, turn) {
    const split = Math.ceil(Math.PI / height / widest), edge = Math.PI / height / split;
    const block = Math.floor(widest / edge), of = n => Math.ceil(n * split / block);
    const w = of(width), h = of(height), out = new Float32Array(8 * w * h);
    for (let j = 0; j < height * split; j++) {
        const up = (flipY ? -1 : 1) * ((j + 0.5) * edge - Math.PI / 2);
        const area = 2 * Math.sin(edge / 2) * edge * Math.cos(up);
        for (let i = 0; i < width * split; i++) {
            const from = 4 * (Math.floor(j / split) * width + Math.floor(i / split));
            const to = 8 * (Math.floor(j / block) * w + Math.floor(i / block));
            const across = (i + 0.5) * edge - Math.PI - turn;
            let power = 1e-6 * area; // of black
            for (let c = 0; c < 3; c++) {
                const light = area * Math.max(data[from + c], 0);
                out[to + 4 + c] += light;
                power += light;
            }
            out[to] += power * Math.cos(up) * Math.cos(across);
            out[to + 1] += power * Math.sin(up);
            out[to + 2] += power * Math.cos(up) * Math.sin(across);
        }
    }
    const map = new THREE.DataTexture(out, 2 * w, h, THREE.RGBAFormat, THREE.FloatType);
    map.needsUpdate = true;
    return map;
}

export function createView(canvas) {
    const renderer = new THREE.WebGLRenderer({canvas, antialias: true});
    renderer.toneMapping = THREE.NeutralToneMapping;
    const camera = new THREE.PerspectiveCamera(24, 1, 0.1, 100);
    camera.position.z = 28;
    const orbit = new OrbitControls(camera, canvas);
    orbit.enablePan = false;
    orbit.listenToKeyEvents(canvas);
    orbit.addEventListener('change', draw);
    canvas.style.touchAction = 'pan-y';

    const round = new THREE.SphereGeometry(1, 96, 64), balls = new THREE.Group();
    MATERIALS.forEach(({metalness, color}, row) => ROUGHNESS.forEach((roughness, column) => {
        const ball = new THREE.Mesh(round, fit(
            new THREE.MeshStandardMaterial({roughness, metalness, color})));
        ball.position.set(2.3 * (row - 1), 2.3 * (2 - column), 0);
        balls.add(ball);
    }));
    const scene = new THREE.Scene().add(balls);
    const single = new THREE.Mesh(new THREE.SphereGeometry(1, 96, 64, 0, 2 * Math.PI, 0, 1.37)
        .rotateX(Math.PI / 2)), alone = new THREE.Scene().add(single);
    const far = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.1, 10);
    far.position.z = 5;
    const [looked, summed] = [LOOKUP, SUM].map(lines => {
        const material = fit(new THREE.MeshStandardMaterial(), lines);
        for (const name of ['dFdx(x)', 'dFdy(x)']) // which widens lobes by pixels
            material.defines[name] = '(0.0 * (x))';
        return material;
    });
    const target = new THREE.WebGLRenderTarget(PIXELS, PIXELS, {type: THREE.FloatType});

    /* Of each side the cube, and what was done to its light already. Shaders are
     * made for a number of levels, before there is a map. */
    const sides = [5, 6].map(levels => ({map: dark(levels), rotate: 0, exposure: 0}));
    const sight = {}, drawn = [];
    let sky = null, asked = 0, question = 0;
    /* Lights a scene as side k has it. */
    function light(where, k, exposed) {
        const {map, rotate, exposure} = sides[k];
        uniforms.baked.value = k === 0;
        where.environment = map;
        where.environmentRotation.y = (sight.rotation - rotate) * DEGREE;
        where.environmentIntensity = 2 ** (exposed - exposure);
    }
    function draw() {
        asked ||= requestAnimationFrame(now);
    }
    function now() {
        const {clientWidth: w, clientHeight: h} = canvas;
        asked = 0;
        for (const k of [0, 1]) {
            light(scene, k, sight.exposure);
            scene.background = sight.background === 'none' ? null : scene.environment;
            scene.backgroundBlurriness = sight.background === 'sharp' ? 0 : 0.45;
            scene.backgroundRotation.y = scene.environmentRotation.y;
            scene.backgroundIntensity = scene.environmentIntensity;
            renderer.setViewport(k * w / 2, 0, w / 2, h);
            renderer.setScissor(k * w / 2, 0, w / 2, h);
            renderer.setScissorTest(true);
            renderer.render(scene, camera);
            renderer.setScissorTest(false);
        }
        drawn.splice(0).forEach(go => go());
    }
    const isDrawn = () => new Promise(go => draw(drawn.push(go)));
    new ResizeObserver(() => {
        const {clientWidth: w, clientHeight: h} = canvas;
        renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
        renderer.setSize(w, h, false);
        camera.aspect = w / 2 / h;
        camera.fov = 2 * Math.atan(Math.max(6.6, 3.7 / camera.aspect) / 28) / DEGREE;
        camera.updateProjectionMatrix();
        draw();
    }).observe(canvas);

    function replace(k, map, rotate = 0, exposure = 0, owner = map) {
        (sides[k].owner ?? sides[k].map).dispose();
        sides[k] = {map, rotate, exposure, owner};
        return isDrawn();
    }
    function radiance(material) {
        const pixels = new Float32Array(4 * PIXELS * PIXELS);
        single.material = material;
        renderer.setRenderTarget(target);
        renderer.render(alone, far);
        renderer.readRenderTargetPixels(target, 0, 0, PIXELS, PIXELS, pixels);
        renderer.setRenderTarget(null);
        return pixels.map((x, i) => i % 4 < 3 ? x : 0);
    }

    return {
        isDrawn,
        set: s => draw(Object.assign(sight, s)),
        /* A specular cube of half floats as KTX2; is done when it is drawn. */
        show({buffer}, rotate, exposure) {
            const view = new DataView(buffer), number = at => view.getUint32(at, true);
            return replace(0, cube(number(20), number(40), (l, face, n) => new Uint16Array(
                buffer, number(80 + 24 * l) + face * n * n * 8, n * n * 4)), rotate, exposure);
        },
        /* A map as three.js reads and prefilters it, or none; gives the time that
         * the latter takes. */
        async prefilter(bytes) {
            sky = null;
            if (!bytes)
                return replace(1, dark(6));
            const exr = new DataView(bytes).getUint32(0, true) === 20000630;
            const loader = exr ? new EXRLoader() : new HDRLoader();
            const read = type => loader.setDataType(type).createDataTexture(bytes);
            sky = read(THREE.FloatType);
            const {width: w, height: h, data} = sky.image;
            if (data.length !== 4 * w * h || w !== 2 * h || h > 2048)
                throw Error(`${w} x ${h} pixels: only 2:1, up to 4096 x 2048, is compared`);
            const map = read(THREE.HalfFloatType);
            map.mapping = THREE.EquirectangularReflectionMapping;
            const start = performance.now(), generator = new THREE.PMREMGenerator(renderer);
            const made = generator.fromEquirectangular(map);
            generator.dispose();
            map.dispose();
            renderer.readRenderTargetPixels(made, 0, 0, 1, 1, new Uint16Array(4), 0);
            const took = performance.now() - start;
            await replace(1, made.texture, 0, 0, made);
            return took;
        },
        /* Radiance of a sphere that is seen from far away, without its rim, RGB0 from
         * the bottom: of both sides and the truth. Nothing if it was asked again meanwhile. */
        async measure(row, column) {
            const id = ++question, {metalness, color} = MATERIALS[row];
            for (const material of [looked, summed])
                Object.assign(material, {metalness, color, roughness: ROUGHNESS[column]});
            const out = [0, 1].map(k => {
                light(alone, k, 0);
                return radiance(looked);
            });
            const patches = patchesOf(sky, ROUGHNESS[column] ** 2 / 3, sight.rotation * DEGREE);
            const truth = new Float32Array(out[0].length), {height} = patches.image;
            for (let at = 0; at < height && id === question; at += 8) { // not to hold it up
                uniforms.rows.value.set(at, Math.min(at + 8, height));
                uniforms.patches.value = patches;
                radiance(summed).forEach((x, i) => truth[i] += x);
                await new Promise(go => setTimeout(go));
            }
            patches.dispose();
            return id === question && [...out, truth];
        },
        /* A model of glTF in one file; nothing: spheres again. */
        async model(url) {
            let loaded = balls;
            if (url) {
                loaded = (await new GLTFLoader().loadAsync(url)).scene;
                const box = new THREE.Box3().setFromObject(loaded);
                const scale = 11 / box.getSize(new THREE.Vector3()).length();
                loaded.position.sub(box.getCenter(new THREE.Vector3())).multiplyScalar(scale);
                loaded.scale.multiplyScalar(scale);
                loaded.traverse(part => part.material && fit(part.material));
            }
            scene.clear().add(loaded);
            orbit.reset();
            draw();
        }
    };
}
