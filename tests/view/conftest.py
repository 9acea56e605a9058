"""An open page that complains about nothing."""

import pytest


@pytest.fixture
def page(session_browser):
    """An open page that is checked, after the test, for requests and complaints."""
    session_browser.requests.clear()
    session_browser.complaints.clear()
    yield session_browser
    session_browser.leave()
    assert session_browser.requests == []
    assert session_browser.complaints == []
