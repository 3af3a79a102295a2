"""The page of marks: texts stay texts, and what goes back is checked."""

from ichain_drake.errors import InputError
from ichain_drake.visualization.label_page import LabelPage, label_page

EVIL = "</script><script>alert(1)</script>"
CONTENT = {"title": EVIL, "notice": "", "interactions": [EVIL], "logs": [], "marks": []}


def test_texts_stay_texts_and_nothing_is_fetched() -> None:
    page = label_page(CONTENT)
    assert b"<script>alert" not in page
    assert b"http://" not in page
    assert b"https://" not in page


def test_what_is_sent_is_saved_or_refused_in_words() -> None:
    saved, ended = [], []

    def save(rows: list) -> str:
        if not rows:
            raise InputError("mark 1: it is none")
        saved.extend(rows)
        return "1 mark saved"

    page = LabelPage(CONTENT, save, lambda: ended.append(True))
    try:
        assert page._saved([{"piece": "a"}]) == {"text": "1 mark saved"}
        assert page._saved([]) == {"error": "mark 1: it is none"}
        assert page._saved({"piece": "a"}) == page._saved(["a"]) == {"error": "the page sent no marks"}
        assert page._ended({}) == {}
    finally:
        page.close()
    assert (saved, ended) == ([{"piece": "a"}], [True])
