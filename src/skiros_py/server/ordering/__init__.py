"""What comes in as an order becomes one: goals of any form as texts, templates filled in, orders for the queue."""
