"""Take a picture of a playback at a time [s]. Needs the dev extra, Chromium and its driver.

python docs/screenshot.py playback.html 25 picture.png
"""

import io
import shutil
import sys
from pathlib import Path

from PIL import Image
from selenium import webdriver
from selenium.webdriver.support.ui import WebDriverWait

FLAGS = "--headless --no-sandbox --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --hide-scrollbars"
COLORS = 128  # a palette keeps the file small


def main(page: Path, seconds: float, file: Path) -> None:
    """Open the playback in headless Chromium, go to a time, and write what is drawn there."""
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or shutil.which("google-chrome") or ""
    for flag in [*FLAGS.split(), "--window-size=1280,800"]:
        options.add_argument(flag)
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))
    try:
        driver.get(f"{page.resolve().as_uri()}#t={seconds}")
        ready = "return typeof ichain == 'object' && ichain.ready"
        WebDriverWait(driver, 60, 0.1).until(lambda _: driver.execute_script(ready))
        driver.execute_async_script(
            "const done = arguments[0]; let left = 10;"
            "const next = () => left-- ? requestAnimationFrame(next) : done(true); next()"
        )
        image = Image.open(io.BytesIO(driver.get_screenshot_as_png())).convert("RGB")
    finally:
        driver.quit()
    image.quantize(COLORS).save(file, optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), float(sys.argv[2]), Path(sys.argv[3]))
