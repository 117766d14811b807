"""What keeps a platform and its driver safe, whatever an algorithm decides."""
