// `slipfit app`: the page from the command, with the files that it hands over.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { connect } from "node:net";
import { networkInterfaces } from "node:os";
import { after, before, test } from "node:test";
import { assertSameAnswer, command, commanded, examples, launch, open, settled } from "./site.mjs";

let browser;
before(async () => {
  browser = await launch();
});
after(() => browser?.close());

/** The command with these files, and the address that it prints. */
async function started(...files) {
  const app = spawn(command, ["app", "--no-browser", ...files], { cwd: examples });
  let said = "";
  app.stderr.on("data", (more) => (said += more));
  const [line] = await Promise.race([once(app.stdout, "data"), once(app, "exit").then(() => assert.fail(said))]);
  const address = String(line).trim();
  assert.match(address, /^http:\/\/127\.0\.0\.1:\d+\/[0-9a-f]{32}\/$/);
  return { app, address };
}

async function ended(app) {
  app.kill("SIGINT");
  return (await once(app, "exit"))[0];
}

test("the files named are answered in the page as by the command, and Ctrl-C ends it", async () => {
  const { app, address } = await started("classroom_pendulum.csv", "./tuning_fork_9nN_sweep.csv");
  const { page, context, requests, problems } = await open(browser, address);
  const { json, error, command: line } = await settled(page, "./tuning_fork_9nN_sweep.csv");
  assert.equal(error, null);
  assert.equal(line, "slipfit resonance ./tuning_fork_9nN_sweep.csv");
  assertSameAnswer(json, commanded(line), line);
  await page.click('#file-list button:text-is("classroom_pendulum.csv")');
  const first = await settled(page, "classroom_pendulum.csv");
  assertSameAnswer(first.json, commanded(first.command), first.command);
  assert.deepEqual(requests.filter((url) => !url.startsWith(address) && !url.startsWith("blob:")), []);
  assert.equal(await page.evaluate(() => navigator.serviceWorker.controller), null);
  assert.deepEqual(problems, []);
  await context.close();
  assert.equal(await ended(app), 130);
});

test("a wrong token and a foreign page are refused, other addresses of the machine do not answer", async () => {
  const { app, address } = await started("classroom_pendulum.csv");
  const status = async (url, headers = {}) => (await fetch(url, { headers })).status;
  assert.equal(await status(address), 200);
  assert.equal(await status(new URL("/", address)), 403);
  assert.equal(await status(address.replace(/[0-9a-f]{32}/, "0".repeat(32))), 403);
  assert.equal(await status(address, { origin: "https://evil.example" }), 403);
  assert.equal(await status(`${address}handed/1`), 404);
  const named = address.replace("127.0.0.1", "localhost");
  assert.equal(await status(named).catch(() => 403), 403);
  const others = Object.values(networkInterfaces()).flat().filter((net) => !net.internal && net.family === "IPv4");
  const { port } = new URL(address);
  for (const host of [...others.map((net) => net.address), ...(process.platform === "linux" ? ["127.0.0.2"] : [])]) {
    const socket = connect({ host, port });
    const outcome = await Promise.race([once(socket, "connect").then(() => "answered", (e) => e.code)]);
    socket.destroy();
    assert.notEqual(outcome, "answered", host);
  }
  await ended(app);
});

test("a file that is gone by then is told in the page, and the others are answered", async () => {
  const { mkdtempSync, rmSync, writeFileSync } = await import("node:fs");
  const { tmpdir } = await import("node:os");
  const { join } = await import("node:path");
  const gone = join(mkdtempSync(join(tmpdir(), "slipfit-")), "gone.csv");
  writeFileSync(gone, "x");
  const { app, address } = await started(gone, "classroom_pendulum.csv");
  rmSync(gone);
  const { page, context } = await open(browser, address);
  const { error } = await settled(page, "classroom_pendulum.csv");
  assert.equal(error, null);
  await page.locator("#file-list .file button").first().click();
  assert.ok((await page.textContent(".error")).includes("gone.csv: it could not be fetched"));
  await context.close();
  await ended(app);
});
