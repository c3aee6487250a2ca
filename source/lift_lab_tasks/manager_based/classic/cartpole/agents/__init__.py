"""Learning settings of the cart-pole."""
