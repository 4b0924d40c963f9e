"""The one exception that means: the input cannot be used, and this is what to do about it."""


class InputError(ValueError):
    """Unusable input: says where, what was found, what was expected and what to do.

    The command line prints it as one message without a traceback and exits with code 2.
    """

    def __init__(self, where: object, found: str, expected: str, remedy: str = "") -> None:
        message = f"{where}: {found}; expected {expected}"
        super().__init__(f"{message}. {remedy}" if remedy else message)
        self._parts = (where, found, expected, remedy)

    def __reduce__(self) -> tuple[type["InputError"], tuple[str, ...]]:
        """So that a worker process can hand it over; ``where`` travels as text."""
        return type(self), tuple(str(part) for part in self._parts)
