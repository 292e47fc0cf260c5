"""Tasks as Gymnasium environments: the only code that knows Gymnasium."""
