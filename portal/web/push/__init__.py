"""Web Push: tells the browsers of a person that it is their turn, also when no page of the portal is open."""
