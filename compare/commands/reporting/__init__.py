"""The validation report, the page of one scene, and what checks them."""
