// SPDX-License-Identifier: MIT
/*
 * What the pages of the engines share. A page runs the program that --explain
 * prints as it stands. The lines below it in the page, which share its
 * variables, draw: shots of a sphere of radius 1 at the origin, or of the
 * background (no sphere) from the origin, each given to save().
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

    // Pictures are taken when frames were shown, too.
    const context = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function(kind, options) {
        return context.call(this, kind,
                            {...options, preserveDrawingBuffer: true});
    };

    const job = /* JOB */ {};
    const size = job.size;
    const copy = new OffscreenCanvas(size, size);
    const to = copy.getContext('2d', {willReadFrequently: true});
    const canvas = document.querySelector('canvas');
    if (canvas)
        canvas.width = canvas.height = size;

    /* Posts the canvas, in the same task as it was drawn in. */
    async function save(name, from = canvas) {
        to.drawImage(from, 0, 0);
        await post('/saved/' + name, to.getImageData(0, 0, size, size).data);
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
    return {...job, canvas, save, until, next};
})();
