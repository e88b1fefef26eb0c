"""What a contact does: stiffness, conductance, gradients, stress below the surface, flow, partial slip."""
