"""The figures and tables of the source documents as experiments that anyone can run again."""
