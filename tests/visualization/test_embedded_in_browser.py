"""A playback inside another page, as a notebook shows it, in a real browser."""

from pathlib import Path

from patience import PATIENCE

from ichain_drake import PlaybackPage


def test_a_playback_runs_in_a_notebook_frame(browser, page: Path, tmp_path: Path) -> None:
    shown = PlaybackPage(page.read_text(encoding="utf-8"), height=432)
    outer = tmp_path / "outer.html"
    outer.write_text(f"<!doctype html><body>before {shown._repr_html_()} after</body>", encoding="utf-8")
    from selenium.webdriver.support.ui import WebDriverWait

    driver = browser.driver
    driver.get(outer.as_uri())
    frame = driver.find_element("tag name", "iframe")
    assert frame.size["height"] == 432
    assert driver.find_element("tag name", "body").text.split() == ["before", "after"]
    driver.switch_to.frame(frame)
    try:
        ready = "return typeof ichain == 'object' && ichain.ready"
        WebDriverWait(driver, PATIENCE, 0.05).until(lambda _: browser.js(ready))
        browser.seek(3.0)
        assert "test_game" in browser.hud()
        assert "5.00" in browser.hud(), "the first episode starts at 2 s of simulated time"
    finally:
        driver.switch_to.default_content()
