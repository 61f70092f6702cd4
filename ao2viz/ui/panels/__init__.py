"""The panels: each is built once for a browser and synced by the app loop alone."""
