// Everything the page needs, kept after the first visit. The list and its fingerprint are written in when
// the site is built (cargo xtask web).
const NAME = "slipfit-__FINGERPRINT__";
/** @type {string[]} */
const FILES = /*__FILES__*/ [];
const worker = /** @type {any} */ (self);

worker.addEventListener("install", (/** @type {any} */ event) => {
  event.waitUntil(caches.open(NAME).then((cache) => cache.addAll(FILES)).then(() => worker.skipWaiting()));
});

worker.addEventListener("activate", (/** @type {any} */ event) => {
  const old = (/** @type {string[]} */ names) => names.filter((name) => name.startsWith("slipfit-") && name !== NAME);
  event.waitUntil(
    caches.keys().then((names) => Promise.all(old(names).map((name) => caches.delete(name)))).then(() => worker.clients.claim()),
  );
});

/** What comes later, such as the larger module, is kept from then on. @param {Request} request */
async function fetched(request) {
  const response = await fetch(request);
  if (response.ok && request.url.startsWith(worker.registration.scope)) {
    const cache = await caches.open(NAME);
    await cache.put(request, response.clone());
  }
  return response;
}

worker.addEventListener("fetch", (/** @type {any} */ event) => {
  if (event.request.method !== "GET") return;
  event.respondWith(caches.match(event.request).then((kept) => kept ?? fetched(event.request)));
});
