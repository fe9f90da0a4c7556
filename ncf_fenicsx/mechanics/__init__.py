"""The equations of a scene: fields, terms of the virtual work, supports, admissible states."""
