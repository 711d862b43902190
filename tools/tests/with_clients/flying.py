# SPDX-License-Identifier: MIT
"""What tests of flyers share: documents judged by their schemas, and a board at rest."""

import numpy as np
from event_model import DocumentNames, schema_validators


class Documents:
    """All documents of runs, each valid by its schema."""

    def __init__(self):
        self.all = []

    def __call__(self, name, document):
        schema_validators[DocumentNames[name]].validate(document)
        self.all.append((name, document))

    def of(self, name):
        return [document for kind, document in self.all if kind == name]

    def column(self, key, what="data"):
        return np.concatenate([page[what][key] for page in self.of("event_page")])

    @property
    def stop(self):
        return self.of("stop")[-1]


def at_rest(board):
    """Assert that nothing moves any more."""
    states = [axis.state for axis in board.axes()]
    before = [axis.position_steps for axis in board.axes()]
    board.let_pass(0.5)
    assert not {"armed", "running"} & set(states)
    assert [axis.position_steps for axis in board.axes()] == before
