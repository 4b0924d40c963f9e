"""The report in headless Chromium: it draws, it zooms, and the console stays empty."""

import re
import shutil
import subprocess

import numpy as np
import pytest
from matplotlib import image

from gapscope.analysis.gap import report

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
PROBE = """
<script>
addEventListener("load", () => {
  const drawing = () => document.querySelector("#series svg").innerHTML;
  const seen = { whole: drawing() };
  document.querySelector('#series button[data-do="in"]').click();
  seen.zoomed = drawing();
  document.querySelector("#series svg").dispatchEvent(new KeyboardEvent("keydown", { key: "0" }));
  seen.again = drawing();
  const legend = document.querySelector("#series .legend button.nominal");
  legend.click();
  seen.fewer = document.querySelectorAll("#series .curve.nominal").length;
  const wide = document.documentElement.scrollWidth > innerWidth ? "overflows" : "fits";
  document.title = [seen.whole !== seen.zoomed, seen.whole === seen.again, seen.fewer,
    legend.getAttribute("aria-pressed"), wide].join("|");
});
</script>
"""


@pytest.fixture(scope="module")
def browser():
    found = next((path for path in map(shutil.which, NAMES) if path), None)
    if found is None:
        pytest.skip(f"no Chromium on this machine (looked for {', '.join(NAMES)})")
    return found


@pytest.fixture(scope="module")
def html(diagnosed):
    return report.page(diagnosed["friction"])


def run(browser, folder, html, *options):
    """What the browser writes to stdout, and the messages of the page's console."""
    page = folder / "report.html"
    page.write_text(html, encoding="utf-8")
    done = subprocess.run(
        [browser, "--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
         "--enable-logging=stderr", f"--user-data-dir={folder / 'profile'}",
         "--virtual-time-budget=3000", *options, page.as_uri()],
        capture_output=True, text=True, timeout=60, check=True,
    )  # fmt: skip
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


@pytest.mark.parametrize("dark", [False, True])
def test_page_is_drawn_light_and_dark_without_a_word_on_the_console(browser, html, tmp_path, dark):
    picture = tmp_path / "page.png"
    _, console = run(
        browser, tmp_path, html, f"--screenshot={picture}", "--window-size=1000,3000",
        f"--blink-settings=preferredColorScheme={0 if dark else 1}",
    )  # fmt: skip
    assert console == []
    grey = image.imread(picture)[..., :3].mean(axis=2)
    assert (np.median(grey) < 0.2) == dark
    assert grey.std() > 0.05


def test_series_zoom_by_button_and_key_and_narrow_pages_do_not_overflow(browser, html, tmp_path):
    page = html.replace("</body>", f"{PROBE}</body>")
    dom, console = run(browser, tmp_path, page, "--dump-dom", "--window-size=500,900")
    assert console == []
    assert re.search("<title>(.*?)</title>", dom)[1] == "true|true|0|false|fits"
    assert len(re.findall('class="curve measured"', dom)) == 4
