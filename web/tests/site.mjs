// The built site behind a server of static files, and a browser before it.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync } from "node:fs";
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join, normalize, resolve } from "node:path";
import { after, before } from "node:test";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

export const root = resolve(fileURLToPath(new URL("../..", import.meta.url)));
export const site = process.env.SLIPFIT_SITE ?? join(root, "target/site");
export const command = process.env.SLIPFIT_COMMAND ?? join(root, "target/release/slipfit");
/** Measured files that no licence lets anyone pass on; their test is skipped without. */
export const measured = process.env.SLIPFIT_REAL_DATA ?? join(root, "../shared/data");

export const examples = join(root, "examples");
export const bytesOf = (name) => readFileSync(join(examples, name));
/** Pictures to look at. */
export const shots = join(root, "target/web-screenshots");
mkdirSync(shots, { recursive: true });

/** What the command answers, run beside the file so that both name it alike. */
export function commanded(line, cwd = examples) {
  // The line is one for a shell; `--json -` is what the page keeps.
  return execFileSync("sh", ["-c", `"${command}" ${line.replace(/^slipfit /, "")} --json - 2>/dev/null`], { cwd, encoding: "utf8", maxBuffer: 1 << 28 });
}

/** The numbers of both, which two compilers may round differently in their last digits. */
export function assertSameAnswer(mine, theirs, where, tolerance = 1e-6) {
  const compare = (a, b, path) => {
    if (typeof a === "number" && typeof b === "number") {
      assert.ok(a === b || Math.abs(a - b) <= tolerance * Math.max(Math.abs(a), Math.abs(b)) + 1e-300 || near(path, a, b), `${where} ${path}: ${a} and ${b}`);
    } else if (a !== null && typeof a === "object") {
      assert.deepEqual(Object.keys(a), Object.keys(b), `${where} ${path}`);
      for (const key of Object.keys(a)) compare(a[key], b[key], `${path}.${key}`);
    } else {
      assert.equal(a, b, `${where} ${path}`);
    }
  };
  // Differences of nearly equal numbers, and probabilities far in a tail, keep fewer digits.
  const near = (path, a, b) => /residual|p_value|correlation|std_error|background|second_mode|unbounded|interval/.test(path) && Math.abs(a - b) <= 1e-3 * Math.max(Math.abs(a), Math.abs(b), 1e-9);
  compare(JSON.parse(mine), JSON.parse(theirs), "");
}

/** Two texts: their words the same, their numbers near each other. */
export function assertSameText(mine, theirs, where, near) {
  const number = /[-\u2212]?\d+(?:\.\d+)?(?:e[-+]?\d+)?/g;
  const [words, expected] = [mine, theirs].map((text) => text.replace(number, "#").split("\n"));
  expected.forEach((line, i) => assert.equal(words[i], line, `${where}, line ${i + 1}`));
  assert.equal(words.length, expected.length, where);
  const [numbers, values] = [mine, theirs].map((text) => (text.match(number) ?? []).map((n) => Number(n.replace("\u2212", "-"))));
  values.forEach((value, i) => assert.ok(near(numbers[i], value), `${where}: ${numbers[i]} and ${value}`));
}

const TYPES = {
  ".css": "text/css",
  ".csv": "text/csv",
  ".html": "text/html",
  ".js": "text/javascript",
  ".svg": "image/svg+xml",
  ".wasm": "application/wasm",
};

/** A server of the site on the loopback interface; `close` ends it. */
export async function serve() {
  const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, "http://localhost").pathname));
    const file = join(site, path.endsWith("/") ? `${path}index.html` : path);
    try {
      if (!file.startsWith(site)) throw new Error("outside");
      const content = await readFile(file);
      response.writeHead(200, { "content-type": TYPES[extname(file)] ?? "application/octet-stream" });
      response.end(content);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  return {
    address: `http://127.0.0.1:${server.address().port}/`,
    close: () => new Promise((done) => {
      server.close(done);
      server.closeAllConnections();
    }),
  };
}

/** A browser; `flags` are added to those that keep it quiet. */
export function launch(flags = []) {
  const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
  const quiet = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update", "--disable-sync"];
  return chromium.launch({ executablePath, args: [...quiet, ...flags] });
}

/** A server and a browser while the tests of a file run; `page` opens the page as `open` does. */
export function whileTesting() {
  let server;
  let browser;
  before(async () => {
    assert.ok(existsSync(join(site, "index.html")), `${site} is not built: cargo xtask web`);
    server = await serve();
    browser = await launch();
  });
  after(async () => {
    await browser?.close();
    await server?.close();
  });
  return { page: (options, hash = "") => open(browser, server.address + hash, options), address: () => server.address };
}

/** The page, ready to take files; `requests` gathers every address asked for, `problems` what the console says. */
export async function open(browser, address, { context: contextOptions = {}, ...options } = {}) {
  const context = await browser.newContext({ ...contextOptions, ...options });
  const page = await context.newPage();
  const requests = [];
  const problems = [];
  context.on("request", (request) => requests.push(request.url()));
  page.on("console", (message) => message.type() === "error" && problems.push(message.text()));
  page.on("pageerror", (error) => problems.push(String(error)));
  await page.goto(address);
  await page.waitForFunction(() => document.documentElement.dataset.ready === "yes", null, { timeout: 60_000 });
  return { page, context, requests, problems };
}

/** Drops files `[{name, bytes}]` onto the page and waits until the last of them is done with. */
export async function drop(page, files) {
  const packed = files.map(({ name, bytes }) => ({ name, base64: Buffer.from(bytes).toString("base64") }));
  await page.evaluate((list) => {
    const transfer = new DataTransfer();
    for (const { name, base64 } of list) {
      const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
      transfer.items.add(new File([bytes], name));
    }
    dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, cancelable: true }));
  }, packed);
  return settled(page, files.at(-1).name);
}

/** Waits until a file has an answer or an error; gives both. */
export async function settled(page, name, timeout = 120_000) {
  const done = (wanted) => {
    const file = window.slipfit.current;
    return file?.name === wanted && (file.answer || file.error) && !document.body.hasAttribute("aria-busy");
  };
  await page.waitForFunction(done, name, { timeout });
  return page.evaluate(() => {
    const { answer, error, took } = window.slipfit.current;
    return { json: answer?.json, command: answer?.command, python: answer?.python, error, took };
  });
}
