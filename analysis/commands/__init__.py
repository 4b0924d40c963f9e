"""One module per command. Only typer is imported at the top: ``gapscope --help`` stays fast."""
