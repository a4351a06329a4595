"""Check that driver boards and backends follow their specifications."""
