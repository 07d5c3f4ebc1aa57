"""The harness of ./dev bench. Standard library, and matplotlib for the plots alone."""
