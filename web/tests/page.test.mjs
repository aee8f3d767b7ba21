// The page in a browser, as a person uses it.
import assert from "node:assert/strict";
import { mkdtempSync, readFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { assertSameAnswer, assertSameText, bytesOf, commanded, drop, root, settled, shots, whileTesting } from "./site.mjs";

const tested = whileTesting();

for (const name of ["classroom_pendulum.csv", "tuning_fork_9nN.csv", "tuning_fork_12nN.csv", "tuning_fork_9nN_waveform.csv", "tuning_fork_9nN_sweep.csv", "tuning_fork_12nN_sweep.csv", "tuning_fork_free_sweep.csv", "tuning_fork_9nN_levels.csv"]) {
  test(`${name} has the answer of the command`, async () => {
    const { page, context, problems } = await tested.page();
    const { json, error, command: line } = await drop(page, [{ name, bytes: bytesOf(name) }]);
    assert.equal(error, null);
    assertSameAnswer(json, commanded(line), name);
    assert.equal(await page.textContent("#sentence"), JSON.parse(json).sentence);
    assert.deepEqual(problems, []);
    await context.close();
  });
}

test("a resonance curve takes its friction-free reference by one click on the example", async () => {
  const { page, context } = await tested.page();
  await page.click("#example-resonance");
  const { json, command: line } = await settled(page, "tuning_fork_9nN_sweep.csv");
  assert.equal(line, "slipfit resonance tuning_fork_9nN_sweep.csv --reference tuning_fork_free_sweep.csv");
  assertSameAnswer(json, commanded(line), "reference");
  await context.close();
});

test("every example answers by one click", async () => {
  const { page, context, problems } = await tested.page();
  for (const [key, name] of [["pendulum", "classroom_pendulum.csv"], ["fork", "tuning_fork_9nN.csv"], ["viscous", "viscous_decay.csv"], ["beat", "two_modes.csv"], ["levels", "tuning_fork_9nN_levels.csv"]]) {
    await page.click(`#example-${key}`);
    const { error, json } = await settled(page, name);
    assert.equal(error, null, name);
    if (key === "viscous") assert.equal(JSON.parse(json).sliding.detected, false);
    if (key === "beat") assert.ok(JSON.parse(json).warnings.length > 0);
  }
  assert.equal(await page.locator("#file-list .file").count(), 5);
  assert.deepEqual(problems, []);
  await context.close();
});

test("options are changed in place and stand in the command and in the link", async () => {
  const { page, context } = await tested.page();
  await page.click("#example-pendulum");
  await settled(page, "classroom_pendulum.csv");
  await page.click("summary");
  await page.selectOption("#option-constant", "torsion_stiffness");
  await page.fill("#option-torsion_stiffness", "12");
  await page.fill("#option-torsion_stiffness-1", "0,5");
  await page.press("#option-torsion_stiffness-1", "Enter");
  await page.waitForFunction(() => window.slipfit.current.answer?.command.includes("0.5"));
  await page.fill("#option-end_s", "25");
  await page.press("#option-end_s", "Tab");
  await page.waitForFunction(() => window.slipfit.current.answer?.command.includes("--end"));
  const { json, command: line } = await settled(page, "classroom_pendulum.csv");
  assert.equal(line, "slipfit ringdown classroom_pendulum.csv --end 25 --torsion-stiffness '12±0.5'");
  assertSameAnswer(json, commanded(line), "options");
  assert.ok(JSON.parse(json).parameters.coulomb_force.value > 0);
  const link = await page.getAttribute("#take-link", "href");
  assert.deepEqual(JSON.parse(new URLSearchParams(new URL(link).hash.slice(1)).get("options")), { end_s: 25, torsion_stiffness: [12, 0.5] });
  await context.close();
  // The link alone sets the options of the next file.
  const { page: other, context: second } = await tested.page({}, new URL(link).hash);
  const again = await drop(other, [{ name: "classroom_pendulum.csv", bytes: bytesOf("classroom_pendulum.csv") }]);
  assert.equal(again.command, line);
  await second.close();
});

test("further laws and the loss without a model are asked for by name", async () => {
  const { page, context } = await tested.page();
  await page.click("#example-pendulum");
  await settled(page, "classroom_pendulum.csv");
  await page.click("summary");
  const offered = await page.locator("#option-model option").evaluateAll((list) => list.map((option) => option.value));
  for (const model of ["viscous+sliding", "viscous+stribeck", "viscous+presliding", "viscous+power", "viscous+cubic"]) {
    assert.ok(offered.includes(model), `${model} is not among ${offered.join(", ")}`);
  }
  await page.selectOption("#option-law", "free");
  await page.waitForFunction(() => window.slipfit.current.answer?.command.includes("--law free"));
  const free = await settled(page, "classroom_pendulum.csv");
  assert.ok(JSON.parse(free.json).free_law.curve.amplitude.length > 10);
  assertSameAnswer(free.json, commanded(free.command), "free law");
  await page.selectOption("#option-law", "");
  await page.waitForFunction(() => window.slipfit.current.answer && !window.slipfit.current.answer.command.includes("--law"));
  await page.selectOption("#option-model", "viscous+stribeck");
  await page.waitForFunction(() => window.slipfit.current.answer?.command.includes("viscous+stribeck"));
  const { json } = await settled(page, "classroom_pendulum.csv");
  assert.equal(JSON.parse(json).model, "viscous+stribeck");
  await context.close();
});

test("several files dropped at once are all answered, each behind its name", async () => {
  const { page, context, problems } = await tested.page();
  const names = ["classroom_pendulum.csv", "tuning_fork_9nN_sweep.csv", "tuning_fork_9nN_levels.csv"];
  await drop(page, names.map((name) => ({ name, bytes: bytesOf(name) })));
  for (const name of names) {
    await page.click(`#file-list button:text-is("${name}")`);
    const { json, error } = await settled(page, name);
    assert.equal(error, null, name);
    assert.equal(await page.textContent("#sentence"), JSON.parse(json).sentence);
  }
  await page.click('#file-list button[aria-label="Remove classroom_pendulum.csv"]');
  assert.equal(await page.locator("#file-list .file").count(), 2);
  assert.deepEqual(problems, []);
  await context.close();
});

test("a hint is applied by its button", async () => {
  const { page, context } = await tested.page();
  const rows = ["x (m)"];
  for (let i = 0; i < 2000; i++) rows.push(String(Math.exp(-i / 700) * Math.cos(0.3 * i)));
  const { error } = await drop(page, [{ name: "bare.csv", bytes: Buffer.from(rows.join("\n")) }]);
  assert.ok(error.hints.some((hint) => hint.option === "rate_hz"), JSON.stringify(error));
  await page.fill("#option-rate_hz", "100");
  await page.press("#option-rate_hz", "Enter");
  await page.waitForFunction(() => window.slipfit.current.answer);
  await page.click("#example-beat");
  await settled(page, "two_modes.csv");
  const button = page.locator(".warnings button", { hasText: "Use the band" }).first();
  await button.click();
  await page.waitForFunction(() => window.slipfit.current.answer?.command.includes("--band"));
  await context.close();
});

test("a hint without a value leads to its control", async () => {
  const { page, context } = await tested.page({ viewport: { width: 360, height: 740 } });
  await page.evaluate(async () => {
    const bytes = new Uint8Array(await (await fetch("examples/tuning_fork_9nN_sweep.csv")).arrayBuffer());
    await window.slipfit.take("fork.csv", bytes, { options: { model: "sliding" } });
  });
  assert.ok(!(await page.locator("#option-drive_amplitude").isVisible()));
  await page.locator(".warnings button", { hasText: "Choose" }).first().click();
  assert.equal(await page.evaluate(() => document.activeElement.id), "option-drive_amplitude");
  assert.ok(await page.locator("#option-drive_amplitude").isVisible());
  // On a phone a parameter is seen with its uncertainty and unit.
  const edges = await page.locator("table.parameters tbody tr").first().locator("td:nth-child(5)").boundingBox();
  assert.ok(edges.x + edges.width <= 360, JSON.stringify(edges));
  await context.close();
});

test("the window of the decay is dragged, and moved by keys", async () => {
  const { page, context } = await tested.page({ viewport: { width: 1000, height: 1200 } });
  await page.click("#example-pendulum");
  await settled(page, "classroom_pendulum.csv");
  const edge = page.getByRole("slider", { name: "End of the decay" });
  await edge.scrollIntoViewIfNeeded();
  const box = await edge.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x - 400, box.y + box.height / 2, { steps: 5 });
  await page.mouse.up();
  await page.waitForFunction(() => window.slipfit.current.options.end_s > 0 && window.slipfit.current.answer?.command.includes("--end"));
  const dragged = await page.evaluate(() => window.slipfit.current.options.end_s);
  assert.ok(dragged > 10 && dragged < 50, String(dragged));
  await settled(page, "classroom_pendulum.csv");
  const start = page.getByRole("slider", { name: "Begin of the decay" });
  await start.focus();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("Enter");
  await page.waitForFunction(() => window.slipfit.current.answer?.command.includes("--start"));
  await context.close();
});

test("garbage, nothing and a foreign format are refused in words, and the page goes on", async () => {
  const { page, context, problems } = await tested.page();
  const noise = Buffer.from(Array.from({ length: 5000 }, (_, i) => (i * 7919 + (i >> 3) * 104729) & 255));
  for (const [name, bytes] of [["noise.bin", noise], ["empty.csv", Buffer.alloc(0)], ["paper.pdf", Buffer.from("%PDF-1.7\n%âãÏÓ\n")], ["cut.parquet", Buffer.from("PAR1aaaaaaaaPAR1")]]) {
    const { error } = await drop(page, [{ name, bytes }]);
    assert.ok(error?.message.includes(name), `${name}: ${JSON.stringify(error)}`);
    assert.ok(await page.isVisible(".error"));
  }
  const { error } = await drop(page, [{ name: "classroom_pendulum.csv", bytes: bytesOf("classroom_pendulum.csv") }]);
  assert.equal(error, null);
  assert.deepEqual(problems, []);
  await context.close();
});

test("names and headers that hold markup are text", async () => {
  const { page, context, problems } = await tested.page();
  const evil = '<img src=x onerror="window.hit=1">';
  const text = bytesOf("classroom_pendulum.csv").toString().replace("displacement (rad)", `"${evil.replaceAll('"', '""')} (rad)"`);
  const { error } = await drop(page, [{ name: `${evil}.csv`, bytes: Buffer.from(text) }, { name: `<svg onload=window.hit=1>.csv`, bytes: Buffer.from(text) }]);
  assert.equal(error, null);
  assert.equal(await page.evaluate(() => window.hit), undefined);
  assert.equal(await page.locator("main img, [onerror], [onload]").count(), 0);
  assert.ok((await page.textContent("#result")).includes("onerror"));
  assert.deepEqual(problems, []);
  await context.close();
});

test("no request leaves the site, and nothing is sent", async () => {
  const { page, context, requests } = await tested.page();
  const sent = [];
  page.on("request", (request) => (request.method() !== "GET" || request.postData()) && sent.push(request.url()));
  for (const name of ["classroom_pendulum.csv", "tuning_fork_9nN_sweep.csv"]) await drop(page, [{ name, bytes: bytesOf(name) }]);
  await page.click("#tab-simulate");
  await page.waitForSelector("#simulate .u-legend");
  assert.ok(requests.length > 5);
  assert.deepEqual(requests.filter((url) => !url.startsWith(tested.address()) && !url.startsWith(`blob:${tested.address()}`)), []);
  assert.deepEqual(sent, []);
  const policy = await page.getAttribute("meta[http-equiv]", "content");
  assert.ok(policy.includes("default-src 'self'") && !policy.replace("wasm-unsafe-eval", "").includes("unsafe"), policy);
  await context.close();
});

test("it works offline after the first visit", async () => {
  const { page, context } = await tested.page();
  await page.waitForFunction(() => document.documentElement.dataset.offline === "ready");
  await page.reload();
  await page.waitForFunction(() => navigator.serviceWorker.controller !== null);
  await context.setOffline(true);
  await page.reload();
  await page.waitForFunction(() => document.documentElement.dataset.ready === "yes");
  await page.click("#example-pendulum");
  const { error } = await settled(page, "classroom_pendulum.csv");
  assert.equal(error, null);
  await context.close();
});

test("an Arrow, Parquet, HDF5 or packed sound file brings the larger module", async () => {
  const { page, context, requests } = await tested.page();
  const larger = () => requests.filter((url) => url.includes("slipfit_wasm_formats"));
  assert.deepEqual(larger(), []);
  const folder = join(root, "validation/reference/writers");
  for (const name of ["duckdb_gzip_V1.parquet", "h5py_gzip_v108.h5"]) {
    const { json, error, command: line } = await drop(page, [{ name, bytes: readFileSync(join(folder, name)) }]);
    assert.equal(error, null, name);
    assertSameAnswer(json, commanded(line, folder), name);
  }
  assert.equal(new Set(larger()).size, 2);
  // 26000 exp(-3 t) cos(2 pi 200 t), which the codecs with loss keep to a few thousandths.
  for (const name of ["sound.m4a", "sound.mp3", "sound.ogg", "sound.flac", "sound_alac.m4a"]) {
    const { json, error } = await drop(page, [{ name, bytes: readFileSync(join(folder, name)) }]);
    assert.equal(error, null, name);
    const { frequency_hz: frequency, decay_rate_per_s: decay } = JSON.parse(json).parameters;
    assert.ok(Math.abs(frequency.value - 200) < 0.01, `${name}: ${frequency.value} Hz`);
    assert.ok(Math.abs(decay.value - 3) < 0.05, `${name}: ${decay.value} 1/s`);
  }
  await context.close();
});

test("the simulation draws, and its decay is analysed", async () => {
  const { page, context, problems } = await tested.page();
  await page.click("#tab-simulate");
  await page.waitForSelector("#simulate .u-legend");
  await page.locator("#slider-friction").fill("0.8");
  await page.waitForFunction(() => document.querySelector("#slider-friction + output").textContent === "0.80");
  await page.waitForTimeout(500);
  await page.screenshot({ path: join(shots, "simulate-1280.png"), fullPage: true });
  await page.click("#simulate-analyse");
  const { json, error } = await settled(page, "simulated.csv");
  assert.equal(error, null);
  assert.ok(JSON.parse(json).sliding.detected);
  assert.deepEqual(problems, []);
  await context.close();
});

test("everything is reached by keyboard alone", async () => {
  const { page, context } = await tested.page();
  for (let i = 0; i < 20; i++) {
    await page.keyboard.press("Tab");
    if (await page.evaluate(() => document.activeElement.id === "example-pendulum")) break;
  }
  await page.keyboard.press("Enter");
  await settled(page, "classroom_pendulum.csv");
  const reached = new Set();
  for (let i = 0; i < 80; i++) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => document.activeElement.id || document.activeElement.getAttribute("aria-label") || document.activeElement.tagName));
  }
  for (const wanted of ["take-html", "take-json", "take-link", "SUMMARY", "Begin of the decay", "End of the decay"]) {
    assert.ok(reached.has(wanted), `${wanted} is not among ${[...reached].join(", ")}`);
  }
  await page.focus("#tab-analyse");
  await page.keyboard.press("ArrowRight");
  assert.ok(await page.isVisible("#measure"));
  await context.close();
});

/** A file that a button of the page hands out: its name and its text. */
async function handed(page, what) {
  const [download] = await Promise.all([page.waitForEvent("download"), page.click(`#take-${what}`)]);
  return [download.suggestedFilename(), readFileSync(await download.path(), "utf8")];
}

test("files are handed out: report, figure, answer, numbers", async () => {
  const { page, context } = await tested.page();
  await page.click("#example-pendulum");
  const { json } = await settled(page, "classroom_pendulum.csv");
  assert.deepEqual(await handed(page, "json"), ["classroom_pendulum.json", json]);
  const [name, report] = await handed(page, "html");
  assert.equal(name, "classroom_pendulum.html");
  assert.ok(report.startsWith("<!DOCTYPE html>") && report.includes("slipfit ringdown classroom_pendulum.csv"));
  const [, markdown] = await handed(page, "markdown");
  assert.ok(markdown.includes(JSON.parse(json).sentence) && markdown.includes("| friction displacement |"), markdown);
  const svg = (await handed(page, "svg"))[1];
  assert.ok(svg.startsWith("<svg"));
  const [png] = await Promise.all([page.waitForEvent("download"), page.click("#take-png")]);
  assert.equal(png.suggestedFilename(), "classroom_pendulum.png");
  const pixels = readFileSync(await png.path());
  assert.equal(pixels.toString("latin1", 1, 4), "PNG");
  const [, width, height] = svg.match(/width="([\d.]+)" height="([\d.]+)"/).map(Number);
  assert.deepEqual([pixels.readUInt32BE(16), pixels.readUInt32BE(20)], [2 * width, 2 * height]);
  // A blank one packs to a fiftieth.
  assert.ok(pixels.length > 50_000, String(pixels.length));
  assert.ok((await handed(page, "csv"))[1].includes("time_s,amplitude"));
  await context.close();
});

test("what is handed out is what the command writes", async () => {
  const { page, context } = await tested.page();
  const folder = mkdtempSync(join(tmpdir(), "slipfit-"));
  const written = (ending) => readFileSync(join(folder, `a.${ending}`), "utf8");
  // A figure has hundredths of a unit; a number may be rounded to the other side.
  const drawn = (a, b) => Math.abs(a - b) <= 0.02 + 1e-3 * Math.abs(b);
  const same = (a, b) => Math.abs(a - b) <= 1e-6 * Math.max(1, Math.abs(b)) || Math.abs(a - b) <= 1e-3 * Math.max(Math.abs(a), Math.abs(b));
  const ofCall = (html) => html.replace(/slipfit \d+\.\d+\.\d+( \([0-9a-f]+\))?/g, "slipfit").replace(/ --(html|csv|plot|json) [^ <]*| --force/g, "");
  for (const name of ["classroom_pendulum.csv", "tuning_fork_9nN_sweep.csv", "tuning_fork_9nN_levels.csv"]) {
    const { command: line } = await drop(page, [{ name, bytes: bytesOf(name) }]);
    commanded(`${line} --html ${folder}/a.html --csv ${folder}/a.csv --plot ${folder}/a.svg --force`);
    assertSameText((await handed(page, "csv"))[1], written("csv"), `${name} as CSV`, same);
    assertSameText((await handed(page, "svg"))[1], written("svg"), `${name} as SVG`, drawn);
    assertSameText(ofCall((await handed(page, "html"))[1]), ofCall(written("html")), `${name} as HTML`, drawn);
  }
  await context.close();
});

test("what is made on demand is of the answer it stands under, whatever the worker has done since", async () => {
  const { page, context, problems } = await tested.page();
  const pendulum = await drop(page, [{ name: "classroom_pendulum.csv", bytes: bytesOf("classroom_pendulum.csv") }]);
  const fork = await drop(page, [{ name: "tuning_fork_9nN.csv", bytes: bytesOf("tuning_fork_9nN.csv") }]);
  const says = (csv, { json }) => assert.ok(csv.includes(JSON.parse(json).sentence), csv.slice(0, 400));
  const choose = (name) => page.click(`#file-list button:text-is("${name}")`);
  // The worker holds the other file.
  await choose("classroom_pendulum.csv");
  const [name, csv] = await handed(page, "csv");
  assert.equal(name, "classroom_pendulum.slipfit.csv");
  says(csv, pendulum);
  // Another answer of the same file.
  await page.click("summary");
  await page.fill("#option-end_s", "25");
  await page.press("#option-end_s", "Enter");
  await page.waitForFunction(() => window.slipfit.current.answer?.command.includes("--end"));
  const short = await settled(page, "classroom_pendulum.csv");
  assert.notEqual(JSON.parse(short.json).sentence, JSON.parse(pendulum.json).sentence);
  says((await handed(page, "csv"))[1], short);
  assert.ok((await handed(page, "html"))[1].includes("slipfit ringdown classroom_pendulum.csv --end 25"));
  // A worker that was ended holds none.
  const { error } = await drop(page, [{ name: "large.csv", bytes: Buffer.alloc(51e6, "no table\n") }]);
  assert.ok(error);
  await choose("tuning_fork_9nN.csv");
  says((await handed(page, "csv"))[1], fork);
  await choose("classroom_pendulum.csv");
  says((await handed(page, "csv"))[1], short);
  assert.equal(await page.textContent("#status"), "classroom_pendulum.slipfit.csv was handed to the browser.");
  assert.deepEqual(problems, []);
  await context.close();
});

test("a report that cannot be made is said, and the page goes on", async () => {
  const { page, context } = await tested.page();
  await page.click("#example-pendulum");
  await settled(page, "classroom_pendulum.csv");
  await page.evaluate(() => (window.slipfit.current.asked = "no options"));
  await page.click("#take-html");
  await page.waitForFunction(() => document.querySelector("#status").textContent.startsWith("classroom_pendulum.html could not be made"));
  const { error } = await drop(page, [{ name: "classroom_pendulum.csv", bytes: bytesOf("classroom_pendulum.csv") }]);
  assert.equal(error, null);
  assert.ok((await handed(page, "html"))[1].startsWith("<!DOCTYPE html>"));
  await context.close();
});
