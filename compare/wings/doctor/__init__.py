"""What this machine has and lacks: packages, libraries, drawing, folders, memory, licences."""
