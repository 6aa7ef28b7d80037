// SPDX-License-Identifier: MIT
/*
 * What the pages of the engines share. A page loads one set of files by the
 * lines that the manual gives, draws clients.spheres one after the other, each
 * of radius 1 at the origin, from clients.eye with a field of view of 20 degrees,
 * and gives each to save().
 */
window.clients = (() => {
    const post = (path, body) => fetch(path, {method: 'POST', body});
    const text = x => x instanceof Error ? x.stack :
        typeof x === 'object' ? JSON.stringify(x) : String(x);
    const fail = (...words) => post('/failed', words.map(text).join(' '));
    addEventListener('error', e => fail(e.message, e.filename, e.lineno));
    addEventListener('unhandledrejection', e => fail(e.reason));
    // What an engine has to say of our files.
    for (const kind of ['warn', 'error']) {
        const said = console[kind];
        console[kind] = (...words) => {
            post('/said', words.map(text).join(' '));
            said.apply(console, words);
        };
    }

    const SIZE = 192;
    const canvas = document.querySelector('canvas');
    canvas.width = canvas.height = SIZE;

    /* A picture of the canvas, as it is on the screen. */
    async function save(name) {
        const copy = document.createElement('canvas');
        copy.width = copy.height = SIZE;
        const to = copy.getContext('2d', {willReadFrequently: true});
        to.drawImage(canvas, 0, 0);
        await post('/saved/' + name, to.getImageData(0, 0, SIZE, SIZE).data);
    }
    /* Until test() gives something. */
    async function until(test) {
        for (;;) {
            const got = test();
            if (got)
                return got;
            await new Promise(go => setTimeout(go, 10));
        }
    }
    /* The page of the next set. */
    async function next() {
        location = await (await post('/next')).text();
    }
    return {SIZE, canvas, save, until, next, fail, fov: 20, eye: /* EYE */ [4, 4, 4],
            exposure: /* EXPOSURE */ 1, spheres: /* SPHERES */ []};
})();
