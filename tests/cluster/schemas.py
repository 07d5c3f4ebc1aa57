"""A schema that changes slowly, so that its database can die meanwhile, and what a schema consists of."""

# Each statement that changes the schema waits, whatever brings it up. For a superuser.
SLOWLY = """
CREATE FUNCTION slowly() RETURNS event_trigger LANGUAGE plpgsql AS $$ BEGIN PERFORM pg_sleep(0.05); END $$;
CREATE EVENT TRIGGER slowly ON ddl_command_start EXECUTE FUNCTION slowly();
"""
AT_ONCE = "DROP EVENT TRIGGER slowly; DROP FUNCTION slowly()"

SHAPE = """
SELECT line FROM (
  SELECT format('%s.%s %s %s %s', table_name, column_name, data_type, is_nullable, column_default) AS line
    FROM information_schema.columns WHERE table_schema = 'public'
  UNION ALL SELECT indexdef FROM pg_indexes WHERE schemaname = 'public'
  UNION ALL SELECT 'function ' || proname FROM pg_proc
    WHERE pronamespace = 'public'::regnamespace AND proname <> 'slowly'
  UNION ALL SELECT 'trigger ' || tgname FROM pg_trigger WHERE NOT tgisinternal
  UNION ALL SELECT 'version ' || version FROM meshgauge_schema) AS lines
ORDER BY line
"""
MIGRATING = "SELECT count(*) FROM pg_stat_activity WHERE wait_event = 'PgSleep' AND datname = current_database()"
