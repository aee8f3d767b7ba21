// Everything the page needs, kept after the first visit. The list and its fingerprint are written in when
// the site is built (cargo xtask web).
const NAME = "slipfit-__FINGERPRINT__";
const FILES = /*__FILES__*/ [];

self.addEventListener("install", (event) => {
  event.waitUntil(caches.open(NAME).then((cache) => cache.addAll(FILES)).then(() => self.skipWaiting()));
});

self.addEventListener("activate", (event) => {
  const old = (names) => names.filter((name) => name.startsWith("slipfit-") && name !== NAME);
  event.waitUntil(
    caches.keys().then((names) => Promise.all(old(names).map((name) => caches.delete(name)))).then(() => self.clients.claim()),
  );
});

/** What comes later, such as the larger module, is kept from then on. */
async function fetched(request) {
  const response = await fetch(request);
  if (response.ok && request.url.startsWith(self.registration.scope)) {
    const cache = await caches.open(NAME);
    await cache.put(request, response.clone());
  }
  return response;
}

self.addEventListener("fetch", (event) => {
  if (event.request.method !== "GET") return;
  event.respondWith(caches.match(event.request).then((kept) => kept ?? fetched(event.request)));
});
