"""What a scene is made of, and where maps come from."""
