// The pages in a browser: complete, quiet, as wide as the window, whatever the data.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { complaints, startBrowser } from "./browser.mjs";

const kViews = [{ width: 400, colorScheme: "dark" }, { width: 400 }, { width: 1280 }];
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

// Opens the file and goes through the views; `look` sees each.
async function inspect(path, look) {
  const opened = await browser.open(path);
  for (const view of kViews) {
    await opened.show(view);
    assert.deepEqual(await complaints(opened), [], `${path}, ${JSON.stringify(view)}`);
    await look?.(opened.page, view.width);
  }
  await opened.close();
}

// A real solve with two workers; the patch file.
function solve(scene, ...flags) {
  const output = join(folder, "solved.ply");
  isolux("solve", join(process.env.ISOLUX_SOURCE_DIR, "scenes", scene), "--workers", "2",
    "--threads", "1", "-o", output, ...flags);
  return output;
}

function isolux(...words) {
  execFileSync(join(process.env.ISOLUX_BIN_DIR, "isolux"), words, { stdio: ["ignore", "pipe", "pipe"] });
}

test("the report of a solve shows what it took, what it reached and where its error is", async () => {
  const path = join(folder, "report.html");
  isolux("report", solve("cornell_box/cornell_box.obj", "--unit", "mm", "--accuracy", "0.08"), "-o", path);
  await inspect(path, async (page) => {
    assert.equal(await page.locator("h1").textContent(), "Report: cornell_box.obj");
    const headline = await page.locator("header").textContent();
    for (const words of ["accuracy asked for8 %", "estimated error", "ended byaccuracy reached", "workers2"]) {
      assert.ok(headline.includes(words), `${words} in ${headline}`);
    }
    const titles = await page.locator("h3").allTextContents();
    for (const title of ["Error against time", "Causes of the error", "Links and elements", "Time by phase",
      "CPU by worker", "Load", "Bytes by phase", "Bytes by worker", "The solution", "Its estimated error"]) {
      assert.ok(titles.includes(title), `${title} in ${titles}`);
    }
    assert.equal(await page.locator("img").count(), 2);
    assert.match(await page.locator("section", { hasText: "What the scene calls for" }).textContent(), /of all CPU.*of all rays.*occlusion/);
    assert.equal(await page.locator("figure", { hasText: "CPU by worker" }).locator(".chart text", { hasText: "worker" }).count(), 2);
    const rounds = await page.locator("section", { hasText: "All rounds" }).last().locator("tbody tr").count();
    const dots = await page.locator("figure").first().locator("g[aria-label='dot'] circle").count();
    assert.ok(rounds >= 1 && dots > rounds, `${rounds} rounds, ${dots} dots`);
  });
});

test("a sweep by the command shows its runs", async () => {
  const path = join(folder, "real_sweep.html");
  isolux("sweep", join(process.env.ISOLUX_SOURCE_DIR, "scenes", "cornell_box/cornell_box.obj"), "--unit", "mm",
    "--accuracies", "0.3,0.15", "--workers", "2", "--threads", "1", "-o", path);
  await inspect(path, async (page) => {
    assert.equal(await page.locator("h1").textContent(), "Sweep of cornell_box.obj");
    assert.equal(await page.locator("tbody tr").count(), 2);
    assert.equal(await page.locator("figure").first().locator("g[aria-label='dot'] circle").count(), 4);
  });
});

test("a report of which little is known still shows what is there", async () => {
  await inspect(makePage("report", { title: "bare", rounds: [{ round: 1, error: 0.1, seconds: 0.5 }] }), async (page) => {
    assert.equal(await page.locator("h1").textContent(), "Report: a solve");
    assert.ok((await page.locator("h3").allTextContents()).includes("Error against time"));
  });
  await inspect(makePage("report", { title: "empty" }));
  await inspect(makePage("report", {
    title: "odd", summary: { accuracy: "x", seconds: null, epsilons: 3 }, job: null,
    rounds: [{ round: 1, cpu_s: 3, error: "no", load: [1, 2] }, {}], traffic: [{}], effects: [{}], repairs: [{}],
  }));
});

test("a report of many rounds and workers stays readable", async () => {
  const rounds = Array.from({ length: 24 }, (_, i) => ({
    round: i + 1, error: 0.3 * 0.8 ** i, rms: 0.4 * 0.8 ** i, visibility: 0.1 * 0.8 ** i, closure: 0.01 * 0.9 ** i,
    seconds: 1.5 ** i, refine_s: 0.2 * 1.5 ** i, solve_s: 0.1 * 1.5 ** i, links: 1000 * 1.4 ** i, elements: 500 * 1.3 ** i,
    load: 1.1, migrated_links: 30 * i, cpu_s: Array.from({ length: 32 }, (_, worker) => (1 + worker / 32) * 1.5 ** i),
  }));
  const worker_traffic = Array.from({ length: 32 }, (_, worker) => ["values", "sums", "gather"].map((phase) => (
    { worker: worker + 1, phase, bytes_in: 1e6, bytes_out: 2e6 }))).flat();
  const cpu_s = rounds.flatMap(({ cpu_s }) => cpu_s).reduce((sum, value) => sum + value, 0);
  const effects = [{ name: "mirror", decision: "not-simulated", present: true, bound: 0.03, measured: 0.0042, cpu_s: cpu_s / 8, rays: 12345, links: 77, evidence: "2 materials; too little" }];
  const forecasts = rounds.slice(0, 20).map(({ round, links, seconds }) => ({
    round, seconds: { low: seconds, likely: 2 * seconds, high: 5 * seconds }, links: { low: links, likely: links, high: 2 * links } }));
  const data = { title: "many", name: "many.obj", summary: { seconds: 9000, rays: 49380 }, rounds, forecasts, worker_traffic, effects };
  await inspect(makePage("report", data), async (page) => {
    const forecast = page.locator("figure", { hasText: "Forecast of the time" });
    assert.equal(await forecast.locator("g[aria-label='dot'] circle").count(), 20);
    assert.match(await forecast.locator(".legend").textContent(), /came: 150 min/);
    assert.equal(await page.locator("figure", { hasText: "Bytes by worker" }).locator("rect").count() >= 96, true);
    assert.match(await page.locator("section", { hasText: "What the scene calls for" }).textContent(), /mirror.*3 %.*0.42 %.*12.5 %.*12,345.*25 %.*77.*too little/);
  });
});

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

test("a value shows where one points at it, legible in both colour schemes", async () => {
  const opened = await browser.open(makePage("sweep", sweepOf(["default"], [0.2, 0.1])));
  const chart = opened.page.locator(".chart svg").first();
  for (const colorScheme of ["light", "dark"]) {
    await opened.show({ width: 1280, colorScheme });
    await chart.locator("g[aria-label='dot'] circle").first().hover({ force: true });
    const tip = chart.locator("g[aria-label='tip']", { hasText: "true error" }).first();
    assert.match(await tip.textContent(), /true error 12 %, asked 20 %/);
    const [tipColour, panel] = await tip.locator("path").first().evaluate((path) => [
      getComputedStyle(path).fill, getComputedStyle(path.closest("figure")).backgroundColor]);
    assert.equal(tipColour, panel, colorScheme);
  }
  await opened.close();
});

test("charts follow the width of the window", async () => {
  const opened = await browser.open(makePage("sweep", sweepOf(["default"], [0.2, 0.1])));
  const chart = opened.page.locator(".chart svg").first();
  const widths = [];
  for (const width of [1280, 400, 800]) {
    await opened.show({ width });
    widths.push(await chart.evaluate((svg) => svg.clientWidth));
  }
  assert.ok(widths[1] < widths[0] && widths[1] < widths[2], String(widths));
  await opened.close();
});
