// The pages in a browser: complete, quiet, as wide as the window, whatever the data.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { complaints, settle, startBrowser } from "./browser.mjs";

const kViews = [{ width: 1280 }, { width: 400 }, { width: 400, colorScheme: "dark" }];
let browser;
let folder;

before(async () => {
  folder = mkdtempSync(join(tmpdir(), "isolux-pages."));
  browser = await startBrowser();
});
after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
});

function makePage(kind, data) {
  const input = join(folder, "data.json");
  const output = join(folder, `${kind}.html`);
  writeFileSync(input, JSON.stringify(data));
  execFileSync(process.env.ISOLUX_MAKE_PAGE, [kind, input, output]);
  return output;
}

// Opens the file in every view; `look` sees each.
async function inspect(path, look) {
  for (const view of kViews) {
    const opened = await browser.open(path, view);
    assert.deepEqual(await complaints(opened), [], `${path}, ${JSON.stringify(view)}`);
    await look?.(opened.page, view.width);
    await opened.close();
  }
}

function sweepOf(methods, accuracies) {
  return {
    title: "sweep", scene: "room.obj", workers: 2,
    reference: { description: "a run at 0.5 %", error_estimate: 0.004, points: 262144 },
    runs: methods.flatMap((method, m) => accuracies.map((accuracy) => ({
      method, accuracy, seconds: (1 + m) * 0.2 / accuracy ** 1.5, links: Math.round(300 / accuracy ** 1.3),
      elements: 900, rounds: 4, rays: 1e6, bytes: 3e6, ended_by: "accuracy reached",
      error_estimate: 0.9 * accuracy, error_true: 0.6 * accuracy,
    }))),
  };
}

test("a sweep shows its runs, true and estimated, and the powers they follow", async () => {
  const path = makePage("sweep", sweepOf(["default"], [0.2, 0.1, 0.05, 0.02]));
  await inspect(path, async (page) => {
    assert.equal(await page.locator("figure").count(), 2);
    assert.equal(await page.locator("figure").first().locator("g[aria-label='dot'] circle").count(), 8);
    assert.equal(await page.locator("tbody tr").count(), 4);
    const note = await page.locator("figcaption").first().textContent();
    assert.match(note, /true error ∝ seconds−0\.67/);
    assert.match(await page.locator("tbody tr").first().textContent(), /1\.5/);
  });
});

test("a sweep of several methods tells them apart", async () => {
  const path = makePage("sweep", sweepOf(["cg", "southwell+rotate"], [0.2, 0.05]));
  await inspect(path, async (page) => {
    assert.equal(await page.locator("figure").first().locator(".legend li").count(), 4);
    assert.match(await page.locator("table").textContent(), /southwell\+rotate/);
  });
});

test("a sweep of which little is known still shows what is there", async () => {
  const data = { title: "x", scene: "x", runs: [{ accuracy: 0.1, seconds: 1, error_estimate: 0.05, error_true: 0 }] };
  await inspect(makePage("sweep", data), async (page) => {
    assert.equal(await page.locator("figure").count(), 1);
  });
  await inspect(makePage("sweep", { title: "none", scene: "x", runs: [] }));
});

test("names are text, whatever they hold", async () => {
  const evil = "</script><script>document.title='taken'</script><img src=x onerror=\"document.title='taken'\">";
  const data = sweepOf([evil], [0.2, 0.1]);
  data.scene = evil;
  data.title = evil;
  await inspect(makePage("sweep", data), async (page) => {
    assert.equal(await page.title(), evil);
    assert.equal(await page.locator("img").count(), 0);
    assert.ok((await page.locator("h1").textContent()).includes(evil));
  });
});

test("charts follow the width of the window", async () => {
  const opened = await browser.open(makePage("sweep", sweepOf(["default"], [0.2, 0.1])), { width: 1280 });
  const width = () => opened.page.locator(".chart svg").first().evaluate((chart) => chart.clientWidth);
  const wide = await width();
  await opened.page.setViewportSize({ width: 400, height: 900 });
  await settle(opened.page);
  assert.ok(await width() < wide);
  assert.deepEqual(await complaints(opened), []);
  await opened.close();
});
