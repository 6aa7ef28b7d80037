// SPDX-License-Identifier: MIT
/*
 * node tests/gltf_valid.mjs NPM FILE
 *
 * Prints what gltf-validator, installed under NPM/node_modules, finds wrong in
 * a .gltf and the images that it names: errors and warnings, except that it
 * does not know EXT_lights_image_based.
 */
import {readFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import path from 'node:path';

const [npm, file] = process.argv.slice(2);
const require = createRequire(path.resolve(npm, 'node_modules', 'x.js'));
const validator = require('gltf-validator');
let images = 0;

const report = await validator.validateBytes(
    new Uint8Array(readFileSync(file)), {
        uri: path.basename(file),
        externalResourceFunction: async uri => {
            images++;
            return new Uint8Array(readFileSync(path.join(path.dirname(file),
                decodeURIComponent(uri))));
        },
    });
for (const {code, message, severity, pointer} of report.issues.messages)
    if (severity < 2 && code !== 'UNSUPPORTED_EXTENSION')
        console.log(`${pointer}: ${code}: ${message}`);
if (images !== 12 || report.info.resources.filter(
    r => r.image && r.image.format === 'rgba').length !== 12)
    console.log('not 12 images of RGBA', images);
