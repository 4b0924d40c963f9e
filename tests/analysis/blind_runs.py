"""What a blind run found, to compare it with another run of the same cases."""

import json


def outcome(folder):
    """Answers, log sets and diagnoses of a run without salt and seconds."""
    answers = [json.loads(p.read_text())["answer"] for p in sorted((folder / "answers").iterdir())]
    results = [json.loads(p.read_text()) for p in sorted((folder / "results").iterdir())]
    logs = {p.relative_to(folder): p.read_bytes() for p in folder.glob("cases/*/*")}
    for result in results:
        assert result.pop("error") is None
        assert result.pop("seconds") > 0.0
        result["diagnosis"]["provenance"].pop("seconds")
    return answers, results, logs
