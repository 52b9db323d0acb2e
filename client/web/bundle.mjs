// Bundles the scripts and the style of the pages and writes them as a C++ source:
//   node bundle.mjs SOURCE_FOLDER MODULES_FOLDER OUTPUT.cc
// where `npm ci` has put the libraries into MODULES_FOLDER.
import { writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

const [source, modules, output] = process.argv.slice(2);
const { build } = createRequire(join(modules, "package.json"))("esbuild");

const { outputFiles } = await build({
  entryPoints: [join(source, "main.js")],
  outdir: "bundle",
  bundle: true,
  nodePaths: [modules],
  minify: true,
  write: false,
  format: "iife",
  target: "es2020",
  charset: "utf8",
  legalComments: "eof",
  logLevel: "warning",
});

function textOf(extension) {
  const { text } = outputFiles.find(({ path }) => path.endsWith(extension));
  // Either would end the element that the text is put into.
  if (/<\/(script|style)|<!--/i.test(text)) throw new Error(`${extension}: cannot stand in a page`);
  return text;
}

// A literal of many short ones: readable in a debugger, and within what every compiler takes.
function literal(text) {
  const lines = [];
  const bytes = Buffer.from(text, "utf8");
  for (let start = 0; start < bytes.length; start += 100) {
    const line = [...bytes.subarray(start, start + 100)].map((byte) => {
      const character = String.fromCharCode(byte);
      return byte < 32 || byte > 126 || '"\\?'.includes(character)
        ? `\\${byte.toString(8).padStart(3, "0")}`
        : character;
    }).join("");
    lines.push(`    "${line}"`);
  }
  return lines.join("\n");
}

writeFileSync(output, `// Made by client/web/bundle.mjs.
#include "client/web/bundle.h"

namespace isolux {

std::string_view PageScript() {
  return
${literal(textOf(".js"))};
}

std::string_view PageStyle() {
  return
${literal(textOf(".css"))};
}

}  // namespace isolux
`);
