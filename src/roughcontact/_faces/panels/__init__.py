"""The panels that ship; drawn with matplotlib, extra ``plot``."""
