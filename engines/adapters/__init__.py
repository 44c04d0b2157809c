"""Adapters: every module here that defines an `Engine` is found by listing this folder."""
