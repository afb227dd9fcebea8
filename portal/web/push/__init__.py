"""Web Push and e-mail: tell a person that it is their turn, also when no page of the portal is open."""
