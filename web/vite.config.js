// One HTML file with everything in it, so that a saved page works offline and pip has nothing to build.
import { defineConfig } from "vite";

const SPOTS = { "<!--title-->": 1, "<!--head-->": 1, "<!--blob-->": 1 };

function oneFile() {
  return {
    name: "one-file",
    enforce: "post",
    generateBundle(_, bundle) {
      const page = bundle["index.html"];
      for (const [name, item] of Object.entries(bundle)) {
        if (item === page) continue;
        const text = item.type === "chunk" ? item.code : item.source;
        // a function, since "$&" in the code would mean something to replace()
        const whole = item.type === "chunk"
          ? `<script type="module">${text.replaceAll("</script", "<\\/script")}</script>`
          : `<style>${text}</style>`;
        const tag = item.type === "chunk"
          ? new RegExp(`<script[^>]*src="[^"]*${name}"[^>]*></script>`)
          : new RegExp(`<link[^>]*href="[^"]*${name}"[^>]*>`);
        if (item.type === "chunk") {
          page.source = page.source.replace(tag, "").replace("</body>", () => `${whole}\n</body>`);
        } else {
          page.source = page.source.replace(tag, () => whole);
        }
        delete bundle[name];
      }
      for (const spot of Object.keys(SPOTS)) {
        if (page.source.split(spot).length !== 2) throw new Error(`${spot}: expected once`);
      }
      page.fileName = "page.html";
    },
  };
}

export default defineConfig({
  base: "./",
  plugins: [oneFile()],
  build: {
    outDir: "../lumpedcable/page",
    emptyOutDir: false,
    modulePreload: false,
    assetsInlineLimit: 0,
    cssCodeSplit: false,
    chunkSizeWarningLimit: 1500,
  },
});
