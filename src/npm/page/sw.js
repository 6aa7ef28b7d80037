// SPDX-License-Identifier: MIT
/* Keeps the whole page, VERSION, so that it works without a network. */
const FILES = ['./', /* FILES */].map(name => new Request(name, {cache: 'reload'}));

addEventListener('install', e => e.waitUntil(
    caches.open('iblbake').then(cache => cache.addAll(FILES)).then(() => skipWaiting())));
addEventListener('activate', e => e.waitUntil(clients.claim()));
addEventListener('fetch', e => e.respondWith(
    fetch(e.request).catch(() => caches.match(e.request))));
