"""An engine of a spinning sphere that nothing acts on, with a fault planted by name."""

import json
import math
import os
import signal
import sys
import time
from pathlib import Path

FAULT = sys.argv[1] if len(sys.argv) > 1 else ""
#: The call at which what is wrong with a process goes wrong.
WHEN = "run"
HELLO = {
    "protocol": 1,
    "name": "sphere",
    "version": "1",
    "precision": "double",
    "stock_timestep": None,
    "restart": True,
    "methods": [
        {
            "name": "exact",
            "order": 1,
            "attitude_order": 1,
            "summary": "turns about its axis",
            "effects": [],
        }
    ],
}
answers = os.fdopen(int(os.environ["SPINCHECK_ANSWERS"]), "w", buffering=1)
scene: dict = {}
timestep = 0.0
taken = opened = 0


def state() -> dict:
    t = taken * timestep
    w, (x, y, z) = scene["q"][0], scene["q"][1:]
    speed = math.hypot(*scene["omega"])
    a, b, c = (math.sin(speed * t / 2) * o / speed for o in scene["omega"])
    s = math.cos(speed * t / 2)
    q = (
        s * w - a * x - b * y - c * z,
        s * x + a * w + b * z - c * y,
        s * y - a * z + b * w + c * x,
        s * z + a * y - b * x + c * w,
    )
    com = [r + v * t for r, v in zip(scene["com"], scene["velocity"], strict=True)]
    return {"q": q, "omega": scene["omega"], "com": com, "velocity": scene["velocity"]}


def answer(call: dict) -> dict:
    global scene, timestep, taken, opened
    match call["do"]:
        case "hello":
            return HELLO
        case "open":
            scene, timestep, taken, opened = call["scene"], call["timestep"], 0, opened + 1
            if FAULT == "frees nothing" and opened > 2:
                return {"error": "out of memory"}
            body = {"com": [0, 0, 0], "frame": [1, 0, 0, 0], "arm": None}
            body |= {"mass": scene["mass"], "moments": scene["moments"]}
            return {"body": body, "state": state()}
        case "restart":
            kept = {"omega": scene["omega"]} if FAULT == "restarts with its old spin" else {}
            scene |= {name: call[name] for name in ("q", "omega", "com", "velocity")} | kept
            timestep, taken = call["timestep"], 0 if FAULT != "restarts late" else taken
            return state()
        case "run":
            taken += call["steps"]
            return state()
        case "time":
            begun = time.perf_counter()
            taken += call["steps"]
            return {"seconds": time.perf_counter() - begun}
        case "active":
            return {"active": []}
        case "close":
            return {}
        case other:
            return {"error": f"there is no call '{other}'"}


def refuse(reply: dict, words: str) -> None:
    number = reply["id"]
    reply.clear()
    reply.update(id=number, error=words)


PART = {"mass": 1.0, "com": [0, 0, 0], "moments": [1, 1, 1], "frame": [1, 0, 0, 0]}
#: What goes wrong with the answer to a call, in place.
SPOILT = {
    ("heavier", "open"): lambda reply: reply["body"].update(mass=1.01 * scene["mass"]),
    ("a part too many", "open"): lambda reply: reply["body"].update(
        parts=[PART | {"axis": [0, 0, 1]}]
    ),
    ("confesses", "active"): lambda reply: reply.update(active=["wind"]),
    ("faster than time", "time"): lambda reply: reply.update(seconds=1e6),
    ("no number", WHEN): lambda reply: reply.update(omega=[None, 0.0, 0.0]),
    ("NaN", WHEN): lambda reply: reply.update(omega=[math.nan, 0.0, 0.0]),
    ("three of four", WHEN): lambda reply: reply.update(q=reply["q"][:3]),
    ("a spin too many", WHEN): lambda reply: reply.update(spins=[1.0]),
    ("text for numbers", WHEN): lambda reply: reply.update(com=["0", "0", "0"]),
    ("one key more", WHEN): lambda reply: reply.update(energy=1.0),
    ("another's answer", WHEN): lambda reply: reply.update(id=reply["id"] - 1),
    ("refuses", WHEN): lambda reply: refuse(reply, "the solver\nwill not\x1b[2J"),
    ("refuses hello", "hello"): lambda reply: refuse(reply, "the licence has run out"),
    ("true for one", "hello"): lambda reply: reply.update(id=True),
    ("speaks protocol 2", "hello"): lambda reply: reply.update(protocol=2),
    ("has no methods", "hello"): lambda reply: reply.update(methods=[]),
    ("never says hello", "hello"): lambda reply: time.sleep(600),
    ("changes its name", "hello"): lambda reply: reply.update(version=str(os.getpid())),
}


for line in sys.stdin:
    call = json.loads(line)
    if FAULT == "busy":
        Path(sys.argv[2]).write_text(f"{os.getppid()} {os.getpid()}")
        while True:
            pass
    if call["do"] == WHEN:
        if FAULT == "dies":
            print("assertion failed: norm(q) > 0", flush=True)
            sys.exit(3)
        if FAULT == "dies in node":
            print("Error: Cannot find module 'nowhere.mjs'\n}\n\nNode.js v20.20.2", flush=True)
            sys.exit(1)
        if FAULT == "crashes":
            os.kill(os.getpid(), signal.SIGSEGV)
        if FAULT.startswith("killed by "):
            os.kill(os.getpid(), getattr(signal, FAULT.removeprefix("killed by ")))
        if FAULT == "hangs":
            time.sleep(600)
        if FAULT == "answers to standard output":
            print(json.dumps({"id": call["id"], "states": [0.0] * 100}), flush=True)
            continue
        if FAULT == "prints garbage":
            answers.write("Hello from the physics engine\n")
            continue
        if FAULT == "never ends a line":
            answers.write("[" * (1 << 21))
            continue
        if FAULT == "closes its pipe":
            answers.close()
            time.sleep(600)
        if FAULT == "chats":
            print("stepping " * 100_000, file=sys.stderr)
            print("stepping " * 100_000)
        if FAULT == "speaks unasked":
            answers.write("{}\n{}\n")
    reply = {"id": call["id"]} | answer(call)
    SPOILT.get((FAULT, call["do"]), lambda reply: None)(reply)
    answers.write(json.dumps(reply) + "\n")
