"""Where bodies meet, in closed form: shapes, their nearest points, and how these move."""
