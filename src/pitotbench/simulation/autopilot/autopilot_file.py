"""Write the autopilot of an aircraft from its linear models and gains."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from pitotbench.simulation.autopilot.envelope import Envelope, strict
from pitotbench.simulation.autopilot.frozen_aircraft import FrozenAircraft
from pitotbench.simulation.autopilot.linear_model import Linear
from pitotbench.simulation.autopilot.loops import Gains, has_effect, pull
from pitotbench.units import FOOT, KNOT, STANDARD_GRAVITY, Array

TEMPLATE = Path(__file__).with_name("autopilot.xml")
COLUMNS = 25  # of the table of lever positions
LEAST_LIFT = 0.15  # 1/s, so that an angle of attack for a load factor stays finite
INTEGRAL_SHARE = 0.06  # 1/s, of the altitude gain
SPEED_INTEGRAL_SHARE = 0.3  # of the speed gain
CLIMB_ANGLE = 0.08  # rad at the stall speed: the fastest climb asked for
LEAD = 0.1  # of the speed range: how far the speed command may run ahead


def write_autopilot(
    file: Path, envelope: Envelope, models: Sequence[Linear], gains: Gains, aircraft: FrozenAircraft
) -> None:
    """Write the autopilot as a JSBSim system file of its own."""
    speeds = [point.calibrated / KNOT for point in envelope.points]
    accelerations = np.concatenate([point.gains for point in envelope.points]) / KNOT
    entries = {
        "climb_limit": envelope.stall * CLIMB_ANGLE / FOOT * 60.0,
        "speed_lead": max(1.5, min(6.0, LEAD * (speeds[-1] - speeds[0]))),
        "altitude_gain": gains.altitude,
        "altitude_integral": INTEGRAL_SHARE * gains.altitude,
        "climb_gain": gains.climb,
        "speed_gain": gains.speed,
        "speed_integral": SPEED_INTEGRAL_SHARE * gains.speed**2,
        "most_trim": 0.5 * float(np.abs(accelerations).max()),
    }
    text = TEMPLATE.read_text(encoding="utf-8")
    for key, value in entries.items():
        text = text.replace("{{" + key + "}}", f"{value:.6g}")
    tables = "\n".join(
        _table(name, speeds, values) for name, values in _model(envelope, models, gains).items()
    )
    text = text.replace("{{tables}}", tables).replace(
        "{{levers}}", _levers(envelope, accelerations)
    )
    file.write_text(text.replace("{{engines}}", _throttles(aircraft)), "utf-8")


def write_levers(root: ET.Element, engines: int, taken: str) -> None:
    """Add to an aircraft a system for mixture and propeller levers, which the bench leaves alone.

    `taken` is the text of all files of the aircraft: a lever that they move is left to them.
    """
    system = ET.Element("system", name="attached levers")
    channel = ET.SubElement(system, "channel", name="attached levers")
    # The ratio of the densities, near enough, and the best power of a rich mixture.
    ratio = (
        "<product> <value> 0.85 </value> <quotient> <property> atmosphere/P-psf </property> "
        "<value> 2116.2 </value> </quotient> </product>"
    )
    for lever, value in (
        ("mixture", ratio),
        ("advance", "<sum> <value> 1 </value> <value> 0 </value> </sum>"),
    ):
        if (
            any(f"fcs/{lever}-{kind}-norm" in _outputs(taken) for kind in ("cmd", "pos"))
            and lever == "mixture"
        ):
            continue
        component = ET.SubElement(channel, "fcs_function", name=f"ap/{lever}-lever-norm")
        ET.SubElement(component, "function").append(ET.fromstring(value))
        for i in range(engines):
            ET.SubElement(component, "output").text = f"fcs/{lever}-cmd-norm[{i}]"
    place = (
        max((i for i, e in enumerate(root) if e.tag in ("system", "propulsion")), default=-1) + 1
    )
    root.insert(place, system)
    root.insert(place + 1, ET.Element("system", file="attached-autopilot"))


def open_all_tanks(root: ET.Element) -> None:
    """Let an aircraft's engines draw from tanks that no engine names, as a pilot selects them."""
    engines = list(root.iter("engine"))
    named = {(feed.text or "").strip() for engine in engines for feed in engine.findall("feed")}
    for number, tank in enumerate(root.iter("tank")):
        if tank.get("type") == "FUEL" and str(number) not in named:
            for engine in engines:
                ET.SubElement(engine, "feed").text = str(number)


def _outputs(text: str) -> set[str]:
    """Return the properties that components write, without the numbers of engines."""
    found = text.split("<output>")[1:]
    return {part.split("</output>")[0].strip().split("[")[0] for part in found}


def _model(envelope: Envelope, models: Sequence[Linear], gains: Gains) -> Mapping[str, Array]:
    pitch = np.stack([model.pitch for model in models])
    lateral = np.stack([model.lateral for model in models])
    rudder = lateral[:, 2, 4]
    share = np.array([1.0 / effect if has_effect(effect) else 0.0 for effect in rudder])
    points = envelope.points
    return {
        "elevator-level": np.array([p.elevator for p in points]),
        "alpha-level-rad": np.array([p.alpha for p in points]),
        "lever-level": np.array([p.lever for p in points]),
        "lever-idle": np.array([strict(p.gains, p.levers)[1][0] for p in points]),
        "induced-ktps": _induced(envelope) / KNOT,
        "elevator-effect": pitch[:, 1, 2],
        "pitch-stiffness": pitch[:, 1, 0],
        "pitch-damping": pitch[:, 1, 1],
        "lift": np.maximum(-pitch[:, 0, 0], LEAST_LIFT),
        "pull": np.array([pull(model) for model in models]),
        "pitch-gain": gains.pitch_rate,
        "pitch-integral-gain": gains.pitch_integral,
        "bank-gain": gains.bank,
        "roll-damping-added": gains.roll_rate,
        "roll-damping-total": gains.roll_rate + np.abs(lateral[:, 1, 1]),
        "roll-by-yaw": lateral[:, 1, 2],
        "aileron-effect": lateral[:, 1, 3],
        "rudder-share": share,
        "yaw-stiffness": np.maximum(lateral[:, 2, 0], 0.0),
        "yaw-damping-added": gains.yaw_rate,
        "yaw-by-roll": lateral[:, 2, 1],
        "yaw-by-yaw": lateral[:, 2, 2],
        "yaw-by-aileron": lateral[:, 2, 3],
    }


def _induced(envelope: Envelope) -> Array:
    """Return the deceleration [m/s²] by the induced drag of level flight at each trim point.

    Drag over mass is fitted as a V² + b/V² to the thrust of level flight; only b, the induced part,
    is used.
    """
    speed = np.array([point.speed for point in envelope.points])
    drag = np.array([point.drag for point in envelope.points])
    scale = np.array([point.calibrated / point.speed for point in envelope.points])
    (_, induced), *_ = np.linalg.lstsq(np.stack([speed**2, speed**-2], axis=1), drag, rcond=None)
    found: Array = scale * np.clip(induced / speed**2, 0.0, 0.1 * STANDARD_GRAVITY)
    return found


def _table(name: str, speeds: Sequence[float], values: Array) -> str:
    rows = "\n".join(f"        {v:.2f} {x:.7g}" for v, x in zip(speeds, values, strict=True))
    return (
        f'    <fcs_function name="ap/model/{name}"> <function> <table>\n'
        '      <independentVar lookup="row"> ap/kcas-smooth-kt </independentVar>\n'
        f"      <tableData>\n{rows}\n      </tableData> </table> </function> </fcs_function>"
    )


def _levers(envelope: Envelope, accelerations: Array) -> str:
    columns = np.linspace(accelerations.min(), accelerations.max(), COLUMNS)
    lines = [" ".join(f"{value:.4f}" for value in columns)]
    for point in envelope.points:
        gains, levers = strict(point.gains / KNOT, point.levers)
        row = np.interp(columns, gains, levers)
        lines.append(f"{point.calibrated / KNOT:.2f} " + " ".join(f"{value:.4f}" for value in row))
    return "\n".join(f"            {line}" for line in lines)


def _throttles(aircraft: FrozenAircraft) -> str:
    return "\n".join(_engine(i, aircraft.engines, aircraft.idle) for i in range(aircraft.engines))


def _engine(number: int, engines: int, idle: float) -> str:
    side = "left" if 2 * number < engines else "right"
    return (
        f'    <fcs_function name="ap/throttle-{number}-norm">\n'
        "      <function> <sum> <property> ap/lever-norm </property> <property> "
        f"ap/throttle-bias-{side}-norm "
        "</property> </sum> </function>\n"
        f"      <clipto> <min> {idle:g} </min> <max> 1 </max> </clipto>\n"
        f"      <output> fcs/throttle-cmd-norm[{number}] </output>\n"
        "    </fcs_function>"
    )
