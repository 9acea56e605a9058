"""Robots and scenes as the native core takes them."""
