// SPDX-License-Identifier: MIT
/* Keeps the whole page, so that it works without a network. */
const CACHE = 'iblbake VERSION', FILES = [/* FILES */];

addEventListener('install', e => e.waitUntil((async () => {
    const cache = await caches.open(CACHE);
    await cache.addAll(['./', ...FILES].map(
        name => new Request(name, {cache: 'reload'})));
    await skipWaiting();
})()));
addEventListener('activate', e => e.waitUntil((async () => {
    for (const name of await caches.keys())
        if (name.startsWith('iblbake ') && name !== CACHE)
            await caches.delete(name);
    await clients.claim();
})()));
addEventListener('fetch', e => {
    if (e.request.method === 'GET')
        e.respondWith((async () =>
            await (await caches.open(CACHE)).match(e.request) ||
            fetch(e.request))());
});
