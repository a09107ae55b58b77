"""Opens a page in headless Chromium without a network, and reports what a person would find there.

Usage: browser.py PAGE.html OUT_FOLDER [--no-webgl]

Prints JSON: the console's messages, the requests to a network, whether the view turns, and the
text of the table of figures. OUT_FOLDER gets page.png, page.pdf, and, where the view turns,
before.png and after.png around a drag. Chromium is driven through a pipe in its own protocol.
"""

import base64
import itertools
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

WIDTH, HEIGHT = 1100, 900
PATIENCE_S = 60


class Browser:
    def __init__(self, profile, flags):
        to_read, self.to = os.pipe()
        self.of, to_write = os.pipe()

        def hand_over():
            # Chromium reads from 3 and writes to 4; neither end may be one of these before.
            read, write = os.dup(to_read), os.dup(to_write)
            os.dup2(read, 3)
            os.dup2(write, 4)

        command = [
            os.environ.get("TRACKWRIGHT_CHROMIUM", "chromium"),
            "--headless=new",
            "--remote-debugging-pipe",
            "--no-sandbox",
            "--no-first-run",
            "--disable-dev-shm-usage",
            "--disable-background-networking",
            "--disable-component-update",
            # No name leads anywhere, and no address is reached but through a proxy that is not there.
            "--host-resolver-rules=MAP * ~NOTFOUND",
            "--proxy-server=127.0.0.1:9",
            f"--user-data-dir={profile}",
            f"--window-size={WIDTH},{HEIGHT}",
            *flags,
            "about:blank",
        ]
        self.process = subprocess.Popen(
            command,
            preexec_fn=hand_over,
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_read)
        os.close(to_write)
        self.numbers = itertools.count(1)
        self.rest = b""
        self.events = []
        self.session = None

    def receive(self):
        while b"\0" not in self.rest:
            more = os.read(self.of, 1 << 20)
            if not more:
                raise SystemExit("the browser has gone")
            self.rest += more
        message, self.rest = self.rest.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, **params):
        number = next(self.numbers)
        message = {"id": number, "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.receive()
            if answer.get("id") == number:
                if "error" in answer:
                    raise SystemExit(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def value(self, expression):
        return self.call("Runtime.evaluate", expression=expression, returnByValue=True)["result"].get("value")

    def wait_until(self, expression):
        end = time.monotonic() + PATIENCE_S
        while not self.value(expression):
            if time.monotonic() > end:
                raise SystemExit(f"in vain: {expression}")
            time.sleep(0.05)


def picture(browser, file, clip=None):
    more = {"clip": {**clip, "scale": 1}} if clip else {}
    shot = browser.call("Page.captureScreenshot", format="png", captureBeyondViewport=clip is None, **more)
    file.write_bytes(base64.b64decode(shot["data"]))


def turned(browser, out):
    """The canvas before and after a drag across it."""
    browser.value("document.querySelector('#scene').scrollIntoView({block: 'center'})")
    box = browser.value(
        "(() => { const b = document.querySelector('#scene canvas').getBoundingClientRect();"
        " return {x: b.x, y: b.y, width: b.width, height: b.height}; })()"
    )
    shown = {**box, "x": box["x"], "y": box["y"] + browser.value("window.scrollY")}
    time.sleep(0.5)
    picture(browser, out / "before.png", shown)
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def mouse(kind, at_x, at_y, **more):
        browser.call("Input.dispatchMouseEvent", type=kind, x=at_x, y=at_y, **more)

    mouse("mousePressed", x, y, button="left", buttons=1, clickCount=1)
    for step in range(1, 11):
        mouse("mouseMoved", x + 20 * step, y - 6 * step, button="left", buttons=1)
    mouse("mouseReleased", x + 200, y - 60, button="left", clickCount=1)
    time.sleep(0.5)
    picture(browser, out / "after.png", shown)


def main():
    page, out = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    has_webgl = "--no-webgl" not in sys.argv
    out.mkdir(parents=True, exist_ok=True)
    flags = ["--enable-unsafe-swiftshader", "--use-gl=angle", "--use-angle=swiftshader"]
    if not has_webgl:
        flags = ["--disable-gpu", "--disable-webgl", "--disable-3d-apis"]
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(profile, flags)
        try:
            target = browser.call("Target.createTarget", url="about:blank")["targetId"]
            browser.session = browser.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
            for domain in ["Page", "Runtime", "Log", "Network"]:
                browser.call(f"{domain}.enable")
            browser.call(
                "Emulation.setDeviceMetricsOverride",
                width=WIDTH, height=HEIGHT, deviceScaleFactor=1, mobile=False,
            )
            browser.call("Page.navigate", url=page.as_uri())
            browser.wait_until("location.protocol === 'file:' && document.readyState === 'complete'")
            has_scene = browser.value("!!document.querySelector('#scene canvas')")
            if has_scene and has_webgl:
                browser.wait_until("!!document.querySelector('#scene.turns')")
            time.sleep(0.5)
            turns = browser.value("!!document.querySelector('#scene.turns')")
            if turns:
                turned(browser, out)
            picture(browser, out / "page.png")
            figures = browser.value(
                "[...document.querySelectorAll('#figures table.figures tr')]"
                ".map(row => [...row.children].map(cell => cell.textContent))"
            )
            still = browser.value("(document.querySelector('.still-words') || {}).checkVisibility?.()")
            pdf = browser.call("Page.printToPDF", preferCSSPageSize=True, printBackground=True)
            (out / "page.pdf").write_bytes(base64.b64decode(pdf["data"]))
            browser.call("Runtime.evaluate", expression="0")
        finally:
            browser.process.kill()
            browser.process.wait()
    console, requests = [], []
    for event in browser.events:
        params = event.get("params", {})
        match event.get("method"):
            case "Runtime.consoleAPICalled":
                words = [str(argument.get("value", argument.get("description"))) for argument in params["args"]]
                console.append(f"{params['type']}: {' '.join(words)}")
            case "Runtime.exceptionThrown":
                console.append(f"exception: {params['exceptionDetails']['text']}")
            case "Log.entryAdded":
                console.append(f"{params['entry']['level']}: {params['entry']['text']}")
            case "Network.requestWillBeSent":
                url = params["request"]["url"]
                if url != page.as_uri() and not url.startswith("data:"):
                    requests.append(url)
    print(json.dumps({"console": console, "requests": requests, "turns": turns, "still_words": still, "figures": figures}))


main()
