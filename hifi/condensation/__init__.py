"""How meshed bodies and contacts of one geometry answer forces, condensed in as many processes as there are cores."""
