"""The tables of a result file, as SQL. A changed word is another format: `result_file.FORMAT`."""

from .sweep_tables import SCHEMA as SWEEPS_SCHEMA

_STUDIES_SCHEMA = """
CREATE TABLE environment (
    name TEXT PRIMARY KEY, value TEXT NOT NULL, checksum TEXT NOT NULL);
-- As the adapters declared them to the study, so that a report needs no engine.
CREATE TABLE methods (
    engine TEXT, method TEXT, "order" INTEGER NOT NULL, attitude_order INTEGER NOT NULL,
    summary TEXT NOT NULL, effects TEXT NOT NULL, requires TEXT NOT NULL,
    max_rotation_per_step REAL NOT NULL, as_shipped INTEGER NOT NULL, stock_timestep REAL,
    checksum TEXT NOT NULL, PRIMARY KEY (engine, method));
-- What results rest on: where the engine is empty the scene and this program, else the engine.
CREATE TABLE fingerprints (
    scenario TEXT, engine TEXT, digest TEXT NOT NULL, checksum TEXT NOT NULL,
    PRIMARY KEY (scenario, engine));
CREATE TABLE scenes (
    scenario TEXT PRIMARY KEY, digest TEXT NOT NULL, toml TEXT NOT NULL, method TEXT NOT NULL,
    uncertainty TEXT NOT NULL, conditioning TEXT NOT NULL, horizon REAL, truth BLOB NOT NULL,
    checksum TEXT NOT NULL);
CREATE TABLE rows (
    scenario TEXT, engine TEXT, method TEXT, timestep REAL, engine_version TEXT NOT NULL,
    outcome TEXT NOT NULL, reason TEXT NOT NULL, cause TEXT NOT NULL, lost INTEGER NOT NULL,
    stock INTEGER NOT NULL, unasked TEXT NOT NULL, stopped_at REAL, errors TEXT, drifts TEXT,
    defects TEXT, uncertainty REAL NOT NULL, steps INTEGER NOT NULL, motion BLOB,
    printed TEXT NOT NULL, checksum TEXT NOT NULL,
    PRIMARY KEY (scenario, engine, method, timestep));
CREATE TABLE costs (
    scenario TEXT, engine TEXT, method TEXT, processor TEXT NOT NULL, seconds_per_step REAL,
    seconds_spread REAL, wall_seconds_per_step REAL, checksum TEXT NOT NULL,
    PRIMARY KEY (scenario, engine, method));
-- What pruning saves: an EffectsCost, or the PassCosts of a method, as JSON.
CREATE TABLE left_out (
    scenario TEXT, engine TEXT, method TEXT, kind TEXT, record TEXT NOT NULL,
    checksum TEXT NOT NULL, PRIMARY KEY (scenario, engine, method, kind));
-- What each default of an engine as shipped does to the motion: a DefaultEffects, as JSON.
CREATE TABLE default_effects (
    scenario TEXT, engine TEXT, method TEXT, record TEXT NOT NULL, checksum TEXT NOT NULL,
    PRIMARY KEY (scenario, engine, method));
-- Timesteps are empty for a ladder; the step limit is that of a ladder it cut short, else null.
CREATE TABLE verdicts (
    scenario TEXT, engine TEXT, method TEXT, timesteps TEXT, verdict TEXT NOT NULL,
    reason TEXT NOT NULL, signal TEXT NOT NULL, "order" REAL, limit_error REAL,
    tolerance REAL, signals TEXT NOT NULL, unmet TEXT NOT NULL, as_shipped INTEGER NOT NULL,
    known INTEGER NOT NULL, step_limit INTEGER, checksum TEXT NOT NULL,
    PRIMARY KEY (scenario, engine, method, timesteps));
"""
SCHEMA = _STUDIES_SCHEMA + SWEEPS_SCHEMA
