"""The load test of ./dev load: what is sent, the service under it, the phases, the report."""
