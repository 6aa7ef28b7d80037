// SPDX-License-Identifier: MIT
/* A worker that runs the baker: {id, call, bytes, options} in; {id, progress},
 * then {id, result} or {id, error} out. */
import * as iblbake from './iblbake/index.mjs';

onmessage = async ({data: {id, call, bytes, options}}) => {
    try {
        const onProgress = progress => postMessage({id, progress});
        const result = await iblbake[call](bytes, {...options, onProgress});
        postMessage({id, result}, Object.values(result.files ?? {})
            .map(file => file.buffer));
    } catch (e) {
        postMessage({id, error: e.message || String(e)});
    }
};
