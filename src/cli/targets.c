/* SPDX-License-Identifier: MIT */
#include "cli/targets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/shell_words.h"
#include "json/text.h"

/* What Babylon.js, which three targets are for, needs of each. */
#define BABYLON_BEGINS                                                         \
    "import * as BABYLON from 'babylonjs';\n"                                  \
    "\n"                                                                       \
    "const canvas = document.querySelector('canvas');\n"                       \
    "const engine = new BABYLON.Engine(canvas);\n"                             \
    "const scene = new BABYLON.Scene(engine);\n"                               \
    "const camera = new BABYLON.ArcRotateCamera('camera', 0, 1.2, 4,\n"        \
    "    BABYLON.Vector3.Zero(), scene);\n"                                    \
    "camera.attachControl();\n"
#define BABYLON_LOADS                                                          \
    "const map = BABYLON.CubeTexture.CreateFromPrefilteredData(\n"             \
    "    '{specular}', scene);\n"
#define BABYLON_TAKES                                                          \
    "map.rotationY = 0;\n"                                                     \
    "scene.environmentTexture = map;\n"                                        \
    "scene.environmentIntensity = 1;\n"
#define BABYLON_LIGHT                                                          \
    "const light{n} = new BABYLON.DirectionalLight('light{n}',\n"              \
    "    new BABYLON.Vector3({-x}, {-y}, {-z}), scene);\n"                     \
    "light{n}.diffuse = new BABYLON.Color3({r}, {g}, {b});\n"                  \
    "light{n}.specular = light{n}.diffuse;\n"                                  \
    "light{n}.intensity = {intensity};\n"
#define BABYLON_ENDS "engine.runRenderLoop(() => scene.render());\n"

/* man/iblbake-engines.7 shows options and programs: tests/check-man.sh compares
 * them. */
const ibl_target ibl_targets[IBL_MAX_TARGETS] = {
    {.name = "three",
     .engine = "three.js from r187",
     .options = "--only specular,json --mapping filament --size 384 "
                "--levels 5 --mirror x --pixel uastc-hdr "
                "--quality fast --zstd 18 --sh-format three",
     .takes = "ktx2/uastc-hdr zstd",
     .load = "import * as THREE from 'three';\n"
             "import {KTX2Loader} from 'three/addons/loaders/KTX2Loader.js';\n"
             "\n"
             "const renderer = new THREE.WebGLRenderer();\n"
             "renderer.setSize(innerWidth, innerHeight);\n"
             "document.body.append(renderer.domElement);\n"
             "const scene = new THREE.Scene();\n"
             "const camera = new THREE.PerspectiveCamera(50,\n"
             "    innerWidth / innerHeight);\n"
             "const loader = new KTX2Loader().setTranscoderPath('basis/')\n"
             "    .detectSupport(renderer);\n"
             "const map = await loader.loadAsync('{specular}');\n"
             "map.isPMREMTexture = true;\n"
             "scene.environment = map;\n"
             "scene.environmentIntensity = scene.backgroundIntensity = 1;\n"
             "scene.environmentRotation.y = scene.backgroundRotation.y = 0;\n",
     .background = "scene.background = map;\n",
     .skybox = "scene.background = await loader.loadAsync('{skybox}');\n",
     .light = "const light{n} = new THREE.DirectionalLight(\n"
              "    new THREE.Color({r}, {g}, {b}), {intensity});\n"
              "light{n}.position.set({x}, {y}, {z});\n"
              "scene.add(light{n});\n",
     .end =
         "renderer.setAnimationLoop(() => renderer.render(scene, camera));\n",
     .axes = "x y z",
     .intensity = 1},
    {.name = "babylon",
     .engine = "Babylon.js, DDS files",
     .options = "--only specular,irradiance,json --mapping babylon "
                "--size 256 --mirror xz --format dds --pixel rgba16f "
                "--largest 4096",
     .takes = "dds/rgba16f",
     .load = BABYLON_BEGINS BABYLON_LOADS
     "map.irradianceTexture = BABYLON.CubeTexture.CreateFromPrefilteredData(\n"
     "    '{irradiance}', scene);\n" BABYLON_TAKES,
     .background = "scene.createDefaultSkybox(map, true, 1000);\n",
     .skybox = "const sky = BABYLON.CubeTexture.CreateFromPrefilteredData(\n"
               "    '{skybox}', scene);\n"
               "scene.createDefaultSkybox(sky, true, 1000);\n",
     .light = BABYLON_LIGHT,
     .end = BABYLON_ENDS,
     .whole = true,
     .axes = "z y x",
     .intensity = 1},
    {.name = "babylon-env",
     .engine = "Babylon.js, an .env file",
     .options = "--only specular,json --mapping babylon --size 256 "
                "--mirror xz --format env --overflow clip",
     .takes = "env",
     .load = BABYLON_BEGINS BABYLON_LOADS BABYLON_TAKES,
     .background = "scene.createDefaultSkybox(map, true, 1000);\n",
     .light = BABYLON_LIGHT,
     .end = BABYLON_ENDS,
     .axes = "z y x",
     .intensity = 1},
    {.name = "filament",
     .engine = "Filament",
     .options = "--only specular,json --mapping filament --size 256 "
                "--levels 5 --format ktx --pixel r11g11b10f --sh 2",
     .takes = "ktx/r11g11b10f ktx/rgba16f",
     .load = "// after filament.js of the package, which is no module\n"
             "await new Promise(go => Filament.init(['{specular}'], go));\n"
             "const canvas = document.querySelector('canvas');\n"
             "const engine = Filament.Engine.create(canvas);\n"
             "const scene = engine.createScene();\n"
             "const ibl = engine.createIblFromKtx1('{specular}');\n"
             "ibl.setIntensity(30000);\n"
             "ibl.setRotation([1, 0, 0, 0, 1, 0, 0, 0, 1]);\n"
             "scene.setIndirectLight(ibl);\n",
     .background = "scene.setSkybox(engine.createSkyFromKtx1('{specular}'));\n",
     .skybox = "await new Promise(go => Filament.fetch(['{skybox}'], go));\n"
               "scene.setSkybox(engine.createSkyFromKtx1('{skybox}'));\n",
     .light = "const light{n} = Filament.EntityManager.get().create();\n"
              "Filament.LightManager.Builder(\n"
              "    Filament.LightManager$Type.SUN)\n"
              "    .color([{r}, {g}, {b}])\n"
              "    .intensity({intensity})\n"
              "    .direction([{-x}, {-y}, {-z}])\n"
              "    .sunAngularRadius({degrees})\n"
              "    .build(engine, light{n});\n"
              "scene.addEntity(light{n});\n",
     .end =
         "const camera = "
         "engine.createCamera(Filament.EntityManager.get().create());\n"
         "camera.setProjectionFov(50, canvas.width / canvas.height, .1, 100,\n"
         "    Filament.Camera$Fov.VERTICAL);\n"
         "camera.setExposure(16, 1 / 125, 100);\n"
         "const view = engine.createView();\n"
         "view.setCamera(camera);\n"
         "view.setScene(scene);\n"
         "view.setViewport([0, 0, canvas.width, canvas.height]);\n"
         "const screen = engine.createSwapChain();\n"
         "const renderer = engine.createRenderer();\n"
         "const draw = () => {\n"
         "    renderer.render(screen, view);\n"
         "    requestAnimationFrame(draw);\n"
         "};\n"
         "draw();\n",
     .filament = true,
     .axes = "x y z",
     .intensity = 30000},
    {.name = "bevy",
     .engine = "Bevy 0.16 to 0.18",
     .options = "--only specular,irradiance,json --mapping linear "
                "--size 256 --mirror z --pixel rgb9e5 --zstd 3",
     .takes = "ktx2/rgb9e5 ktx2/rgba16f ktx2/r11g11b10f ktx2/bc6h zstd",
     .load = "use bevy::{core_pipeline::Skybox, prelude::*};\n"
             "\n"
             "fn main() {\n"
             "    App::new()\n"
             "        .add_plugins(DefaultPlugins)\n"
             "        .add_systems(Startup, setup)\n"
             "        .run();\n"
             "}\n"
             "\n"
             "fn setup(mut commands: Commands, assets: Res<AssetServer>) {\n"
             "    commands.spawn((\n"
             "        Camera3d::default(),\n"
             "        EnvironmentMapLight {\n"
             "            diffuse_map: assets.load(\"{irradiance}\"),\n"
             "            specular_map: assets.load(\"{specular}\"),\n"
             "            intensity: 1000.0,\n"
             "            rotation: Quat::IDENTITY,\n"
             "            ..default()\n"
             "        },\n"
             "        Skybox {\n"
             "            image: assets.load(\"{skybox}\"),\n"
             "            brightness: 1000.0,\n"
             "            rotation: Quat::IDENTITY,\n"
             "        },\n"
             "    ));\n",
     .light = "    commands.spawn((\n"
              "        DirectionalLight {\n"
              "            color: Color::linear_rgb({r}, {g}, {b}),\n"
              "            illuminance: {intensity},\n"
              "            ..default()\n"
              "        },\n"
              "        Transform::default()\n"
              "            .looking_to(Vec3::new({-x}, {-y}, {-z}), Vec3::Y),\n"
              "    ));\n",
     .end = "}\n",
     .axes = "x y z",
     .intensity = 1000},
    {.name = "playcanvas",
     .engine = "PlayCanvas",
     .options = "--only specular,json --mapping linear --size 256 "
                "--levels 6 --format playcanvas --overflow clip",
     .takes = "playcanvas",
     .load = "import * as pc from 'playcanvas';\n"
             "\n"
             "const canvas = document.querySelector('canvas');\n"
             "const app = new pc.Application(canvas);\n"
             "app.start();\n"
             "const camera = new pc.Entity();\n"
             "camera.addComponent('camera');\n"
             "app.root.addChild(camera);\n"
             "const asset = new pc.Asset('map', 'texture',\n"
             "    {url: '{specular}'}, {type: 'rgbp', mipmaps: false});\n"
             "asset.ready(() => app.scene.envAtlas = asset.resource);\n"
             "app.assets.add(asset);\n"
             "app.assets.load(asset);\n"
             "app.scene.skyboxIntensity = 1;\n"
             "app.scene.skyboxRotation = new pc.Quat();\n",
     .light = "const light{n} = new pc.Entity();\n"
              "light{n}.addComponent('light', {type: 'directional',\n"
              "    color: new pc.Color({r}, {g}, {b}),\n"
              "    intensity: {intensity}});\n"
              "light{n}.setRotation(new pc.Quat().setFromDirections(\n"
              "    pc.Vec3.UP, new pc.Vec3({x}, {y}, {z})));\n"
              "app.root.addChild(light{n});\n",
     .axes = "-z y x",
     .intensity = 1 / M_PI},
    {.name = "gltf",
     .engine = "glTF with EXT_lights_image_based",
     .options = "--only specular,json --mapping linear --size 256 "
                "--levels 5 --mirror x --format gltf --overflow clip",
     .takes = "gltf",
     .load =
         BABYLON_BEGINS "scene.useRightHandedSystem = true;\n"
                        "await import('babylonjs-loaders');\n"
                        "await BABYLON.AppendSceneAsync('{specular}', scene);\n"
                        "scene.environmentIntensity = 1;\n",
     .background =
         "scene.createDefaultSkybox(scene.environmentTexture, true, 1000);\n",
     .light = BABYLON_LIGHT,
     .end = BABYLON_ENDS,
     .harmonics = true,
     .axes = "x y z",
     .intensity = 1},
    {.name = "cesium",
     .engine = "Cesium",
     .options = "--only specular,json --mapping linear --size 256 "
                "--pixel rgba16f --sh-format cesium",
     .takes = "ktx2/rgba16f",
     .load =
         "import * as Cesium from 'cesium';\n"
         "\n"
         "const viewer = new Cesium.Viewer('cesiumContainer');\n"
         "const place = Cesium.Cartesian3.fromDegrees(0, 0, 100);\n"
         "const model = await Cesium.Model.fromGltfAsync({url: 'model.glb',\n"
         "    modelMatrix: "
         "Cesium.Transforms.eastNorthUpToFixedFrame(place)});\n"
         "viewer.scene.primitives.add(model);\n"
         "const light = model.imageBasedLighting;\n"
         "light.imageBasedLightingFactor = new Cesium.Cartesian2(1, 1);\n"
         "light.specularEnvironmentMaps = '{specular}';\n"
         "light.sphericalHarmonicCoefficients =\n"
         "    Cesium.Cartesian3.unpackArray(\n"
         "        await Cesium.Resource.fetchJson('{sh}'));\n",
     .light = "const frame =\n"
              "    Cesium.Transforms.eastNorthUpToFixedFrame(place);\n"
              "viewer.scene.light = new Cesium.DirectionalLight({\n"
              "    direction: Cesium.Matrix4.multiplyByPointAsVector(\n"
              "        frame, new Cesium.Cartesian3({-x}, {z}, {-y}),\n"
              "        new Cesium.Cartesian3()),\n"
              "    color: new Cesium.Color({r}, {g}, {b}),\n"
              "    intensity: {intensity}});\n",
     .harmonics = true,
     .axes = "x y z",
     .intensity = 1},
};

/* ---- lists --------------------------------------------------------------- */

static int find(const char *name, size_t length)
{
    for (int i = 0; i < IBL_MAX_TARGETS; i++)
        if (strlen(ibl_targets[i].name) == length &&
            !memcmp(ibl_targets[i].name, name, length))
            return i;
    return -1;
}

/* False: a name that there is not. */
static bool take_names(unsigned *bits, const char *value)
{
    for (;;) {
        const size_t length = strcspn(value, ",");
        const int i = find(value, length);
        if (i < 0)
            return false;
        *bits |= 1u << i;
        if (!value[length])
            return true;
        value += length + 1;
    }
}

bool ibl_targets_parse(void *targets, const char *value)
{
    unsigned bits = 0;

    if (!strcmp(value, "list"))
        bits = 1u << IBL_MAX_TARGETS;
    else if (!strcmp(value, "all"))
        bits = (1u << IBL_MAX_TARGETS) - 1;
    else if (!take_names(&bits, value))
        return false;
    *(unsigned *)targets = bits;
    return true;
}

/* ---- the table ------------------------------------------------------------
 */

enum {
    WIDTH = 76, /* of a line of options */
    INDENT = 4
};

/* Breaks lines before options. */
static void print_options(const char *words, FILE *to)
{
    int column = 0;

    while (*words) {
        const char *next = strstr(words + 1, " --");
        const int length = next ? (int)(next - words) : (int)strlen(words);
        if (column + length > WIDTH) {
            fputc('\n', to);
            column = 0;
        }
        const int blank = !column && *words == ' ';
        column += fprintf(to, "%*s%.*s", column ? 0 : INDENT, "",
                          length - blank, words + blank);
        words += length;
    }
    fputc('\n', to);
}

void ibl_targets_print(FILE *to)
{
    for (int i = 0; i < IBL_MAX_TARGETS; i++) {
        fprintf(to, "%s: %s\n", ibl_targets[i].name, ibl_targets[i].engine);
        print_options(ibl_targets[i].options, to);
    }
}

/* ---- lines for an engine --------------------------------------------------
 */

/* Prints lines with holders filled in. */
static void print_lines(const char *lines, const ibl_placeholder *holders,
                        int count, FILE *to)
{
    char *text = ibl_words_fill(lines, holders, count);

    fputs(text ? text : lines, to);
    free(text);
}

/* The component of a direction that one of an engine's axes has: 'x', 'y' or
 * 'z', after '-' for its opposite. */
static double along(const char *axis, const double world[3])
{
    const bool negative = *axis == '-';
    const double x = world[axis[negative] - 'x'];
    return negative ? -x : x;
}

/* The engine's axes are words between single blanks. */
static void turn(const char *axes, const double world[3], double to[3])
{
    for (int i = 0; i < 3; i++) {
        to[i] = along(axes, world);
        axes += strcspn(axes, " ") + (i < 2);
    }
}

enum {
    NUMBERS = 12,
    NUMBER_BYTES = 32
};

typedef struct numbers {
    char text[NUMBERS][NUMBER_BYTES];
    ibl_placeholder holders[NUMBERS];
    int count;
} numbers;

/* Languages take 1.0 for a float, and not all of them 1. */
static void add_number(numbers *n, const char *name, const char *fmt, double x)
{
    snprintf(n->text[n->count], NUMBER_BYTES, fmt, x + 0.0);
    n->holders[n->count] = (ibl_placeholder){name, n->text[n->count]};
    n->count++;
}

static void print_light(const ibl_target *target, const ibl_light *light,
                        int number, FILE *to)
{
    static const char *const names[3][3] = {
        {"x", "y", "z"}, {"-x", "-y", "-z"}, {"r", "g", "b"}};
    static const char *const fmt = "%#.6g";
    const double *e = light->irradiance;
    const double most = fmax(fmax(e[0], e[1]), e[2]);
    double d[3];
    numbers n = {.count = 0};

    turn(target->axes, light->direction, d);
    for (int i = 0; i < 3; i++) {
        add_number(&n, names[0][i], fmt, d[i]);
        add_number(&n, names[1][i], fmt, -d[i]);
        add_number(&n, names[2][i], fmt, e[i] / most);
    }
    add_number(&n, "intensity", fmt, most * target->intensity);
    add_number(&n, "degrees", fmt, light->radius * 180 / M_PI);
    add_number(&n, "n", "%.0f", number);
    print_lines(target->light, n.holders, n.count, to);
}

void ibl_target_explain(const ibl_target *target, const ibl_target_files *files,
                        FILE *to)
{
    const char *skybox = files->skybox ? files->skybox : files->specular;
    const ibl_placeholder holders[] = {{"specular", files->specular},
                                       {"irradiance", files->irradiance},
                                       {"skybox", skybox},
                                       {"sh", files->sh}};
    const char *background =
        files->skybox && target->skybox ? target->skybox : target->background;

    print_lines(target->load, holders, 4, to);
    print_lines(background ? background : "", holders, 4, to);
    if (!files->lights && files->light_count)
        fputs(target->light, to);
    for (int i = 0; i < files->light_count && files->lights; i++)
        print_light(target, &files->lights[i], i + 1, to);
    fputs(target->end ? target->end : "", to);
}
