"""Hostile clients: attacks by name, what may be answered to each, and a service that they are tried on."""
