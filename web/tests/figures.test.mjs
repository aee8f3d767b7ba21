// Figures to look at closely: by pointer, fingers, wheel, keys and buttons.
import assert from "node:assert/strict";
import { test } from "node:test";
import { settled, whileTesting } from "./site.mjs";
import { ticks } from "../zoom.js";

const tested = whileTesting();

/** The page with the pendulum's answer. */
async function answered() {
  const opened = await tested.page({ viewport: { width: 1200, height: 1400 } });
  await opened.page.click("#example-pendulum");
  await settled(opened.page, "classroom_pendulum.csv");
  return opened;
}

/** A panel: its numbers along the axes, and whether it is zoomed. */
function panel(page, i) {
  const figure = page.locator(".figures figure").nth(i);
  const svg = figure.locator("svg");
  return {
    figure,
    svg,
    numbers: () => svg.locator(".ticks text").allTextContents(),
    zoomed: () => svg.evaluate((element) => element.classList.contains("zoomed")),
    box: () => svg.evaluate((element) => {
      const { x, y, width, height } = element.querySelector(".frame").getBoundingClientRect();
      return { x, y, width, height };
    }),
  };
}

test("all four panels zoom by keys and buttons, write new numbers, and show all again", async () => {
  const { page, context, problems } = await answered();
  assert.equal(await page.locator(".figures figure").count(), 4);
  for (let i = 0; i < 4; i++) {
    const { figure, svg, numbers, zoomed } = panel(page, i);
    const before = await numbers();
    await svg.focus();
    for (const key of ["+", "+", "+", "ArrowRight", "ArrowUp"]) await page.keyboard.press(key);
    assert.ok(await zoomed());
    const close = await numbers();
    assert.notDeepEqual(close, before);
    assert.ok(close.length >= 4 && new Set(close).size > 2, close.join(" "));
    await page.keyboard.press("0");
    assert.ok(!(await zoomed()));
    assert.deepEqual(await numbers(), before);
    await figure.getByRole("button", { name: "Zoom in" }).click();
    assert.ok(await zoomed());
    await figure.getByRole("button", { name: "Show all" }).click();
    assert.deepEqual(await numbers(), before);
  }
  assert.deepEqual(problems, []);
  await context.close();
});

test("the wheel zooms where a panel has the focus, and scrolls the page where it has none", async () => {
  const { page, context } = await answered();
  const { svg, zoomed, box } = panel(page, 1);
  await svg.scrollIntoViewIfNeeded();
  const { x, y, width, height } = await box();
  await page.mouse.move(x + width / 2, y + height / 2);
  await page.mouse.wheel(0, -100);
  await page.waitForTimeout(200);
  assert.ok(!(await zoomed()));
  await svg.focus();
  const at = await box();
  await page.mouse.move(at.x + at.width / 2, at.y + at.height / 2);
  await page.mouse.wheel(0, -300);
  await page.waitForFunction(() => document.querySelectorAll(".figures svg.zoomed").length === 1);
  await context.close();
});

test("a dragged rectangle is what is seen afterwards", async () => {
  const { page, context } = await answered();
  const { svg, box } = panel(page, 2);
  await svg.scrollIntoViewIfNeeded();
  const { x, y, width, height } = await box();
  await page.mouse.move(x + 0.5 * width, y + 0.3 * height);
  await page.mouse.down();
  await page.mouse.move(x + 0.7 * width, y + 0.6 * height, { steps: 4 });
  await page.mouse.up();
  // The record lasts 60 s: a fifth of it from the middle on.
  const along = (await svg.locator('.ticks text[text-anchor="middle"]').allTextContents()).map(Number);
  assert.ok(along.length >= 3 && along.every((v) => v >= 29.9 && v <= 42.1), along.join(" "));
  await svg.dblclick({ position: { x: 20, y: 5 } });
  assert.ok(!(await panel(page, 2).zoomed()));
  await context.close();
});

test("two fingers zoom a panel and the record", async () => {
  const { page, context } = await answered();
  const pinch = (selector) =>
    page.locator(selector).first().evaluate((element) => {
      const { x, y, width, height } = element.getBoundingClientRect();
      const send = (type, pointerId, right) => element.dispatchEvent(new PointerEvent(type, { bubbles: true, pointerType: "touch", pointerId, isPrimary: pointerId === 11, clientX: x + right * width, clientY: y + height / 2 }));
      send("pointerdown", 11, 0.45);
      send("pointerdown", 12, 0.55);
      send("pointermove", 11, 0.25);
      send("pointermove", 12, 0.75);
      send("pointerup", 11, 0.25);
      send("pointerup", 12, 0.75);
    });
  const picture = () => page.locator(".record canvas").evaluate((canvas) => canvas.toDataURL());
  const before = await picture();
  await pinch(".figures svg");
  assert.ok(await panel(page, 0).zoomed());
  await pinch(".record .u-over");
  await page.waitForTimeout(100);
  assert.notEqual(await picture(), before);
  await context.close();
});

test("the record zooms by keys and wheel, and shows all again", async () => {
  const { page, context } = await answered();
  const picture = async () => {
    await page.waitForTimeout(100);
    return page.locator(".record canvas").evaluate((canvas) => canvas.toDataURL());
  };
  const over = page.locator(".record .u-over");
  const before = await picture();
  await over.focus();
  await page.keyboard.press("+");
  const close = await picture();
  assert.notEqual(close, before);
  await page.keyboard.press("ArrowRight");
  assert.notEqual(await picture(), close);
  await page.keyboard.press("0");
  assert.equal(await picture(), before);
  await over.scrollIntoViewIfNeeded();
  const box = await over.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.wheel(0, -300);
  assert.notEqual(await picture(), before);
  await context.close();
});

test("the pointer tells the values of the nearest dot, or of the place", async () => {
  const { page, context } = await answered();
  const { figure, svg, box } = panel(page, 1);
  await svg.scrollIntoViewIfNeeded();
  const { told, x, y } = await svg.evaluate((element) => {
    const dot = element.querySelectorAll(".data circle")[5];
    const place = dot.getBoundingClientRect();
    return { told: dot.querySelector("title").textContent.replaceAll("\n", ", "), x: place.x + place.width / 2, y: place.y + place.height / 2 };
  });
  await page.mouse.move(x, y);
  assert.equal(await figure.locator(".value").textContent(), told);
  assert.match(told, /^time [\d.]+ s, amplitude .+ ± .+ rad$/);
  const frame = await box();
  await page.mouse.move(frame.x + 0.02 * frame.width, frame.y + 0.97 * frame.height);
  assert.match(await figure.locator(".value").textContent(), /^time .* s, amplitude .* rad$/);
  await context.close();
});

test("numbers along a part of an axis are round, inside, and enough", () => {
  const linear = { kind: "linear", low: 0, high: 60, label: "time [s]" };
  assert.deepEqual(ticks(linear, 0.5, 0.7, 6).map((t) => t.label), ["30", "32", "34", "36", "38", "40", "42"]);
  assert.deepEqual(ticks({ ...linear, low: -1, high: 1 }, 0.45, 0.55, 5).map((t) => t.label), ["−0.1", "−0.05", "0", "0.05", "0.1"]);
  const log = { kind: "log", low: 0.01, high: 100, label: "amplitude" };
  assert.deepEqual(ticks(log, 0, 1, 5).map((t) => t.label), ["0.01", "0.1", "1", "10", "100"]);
  for (const [from, to] of [[0.1, 0.12], [0.3, 0.8], [0.98, 1]]) {
    const made = ticks(log, from, to, 5);
    assert.ok(made.length >= 2 && made.every((t) => t.share >= from - 1e-6 && t.share <= to + 1e-6), JSON.stringify(made));
  }
});
