"""What tuning came to, as tables and in plain values."""

from mot_sim.experiments.tuning.cross_validation import Tuned
from mot_sim.experiments.tuning.folds import TRAITS
from mot_sim.experiments.tuning.weighing import WEIGHT_SUM
from mot_sim.tables import Column, Row, Table, with_ends


def tuned_tables(tuned: Tuned, objective: str) -> tuple[Table, ...]:
    """The weights, what they are worth, and the folds."""
    weights = [
        (name, weight / WEIGHT_SUM, spread)
        for name, weight, spread in zip(
            tuned.names, tuned.weights, tuned.spread.tolist(), strict=True
        )
    ]
    worth = [
        ("the weights to begin with, all drives", tuned.start),
        ("the mean weights, all drives", tuned.overall),
        ("weights that were chosen without the drive", tuned.held_out),
    ]
    columns = (
        "held out", f"{objective} of the others", f"{objective} held out", "IDSW",
        *(f"weight of {name}" for name in tuned.names),
    )  # fmt: skip
    return (
        Table.of("weights", "Weights of the costs", ("cost", "weight", "std of folds"), weights),
        Table.of("worth", f"{objective} by these weights", ("weights", objective), worth),
        Table.of("folds", "Fold by fold", columns, _folds(tuned)),
    )


def _folds(tuned: Tuned) -> list[Row]:
    """A row a fold: who is held out, both scores, switches, the weights."""
    return [
        (
            " ".join(fold.held), fold.train, fold.held_out, fold.switches,
            *(weight / WEIGHT_SUM for weight in fold.weights),
        )
        for fold in tuned.folds
    ]  # fmt: skip


def fold_table(tuned: Tuned, objective: str) -> Table:
    """The folds for the terminal, then the mean of their weights ± the standard deviation."""
    columns = (
        Column("held out", "name"), Column(f"{objective} train", "rate"),
        Column("held out", "rate", name=f"{objective} held out"), Column("IDSW", "count"),
        *(each for name in tuned.names for each in with_ends(Column(name, "value", digits=3))),
    )  # fmt: skip
    rows = [
        (*row[:4], *(cell for weight in row[4:] for cell in (weight, None, None)))
        for row in _folds(tuned)
    ]
    pairs = zip(tuned.weights, tuned.spread.tolist(), strict=True)
    chosen = [
        cell
        for weight, spread in pairs
        for cell in (
            weight / WEIGHT_SUM,
            weight / WEIGHT_SUM - spread,
            weight / WEIGHT_SUM + spread,
        )
    ]
    switches = sum(fold.switches for fold in tuned.folds)
    rows.append(("all, mean weights ± std", None, tuned.held_out, switches, *chosen))
    return Table(columns, tuple(rows), "weights by cross-validation; scores in %", sums=1)


def tuned_summary(tuned: Tuned, objective: str) -> str:
    """What came of it, in two lines."""
    return (
        f"{objective} of all drives: {100 * tuned.start:.2f} by the first weights, "
        f"{100 * tuned.overall:.2f} by the mean ones, {100 * tuned.held_out:.2f} each by weights "
        f"that were chosen without it\n--costs {tuned.spelled()}\n"
    )


def tuned_content(tuned: Tuned, objective: str) -> dict[str, object]:
    """The outcome in plain values."""
    return {
        "objective": objective,
        "costs": {
            name: {"weight": weight / WEIGHT_SUM, "std": spread}
            for name, weight, spread in zip(
                tuned.names, tuned.weights, tuned.spread.tolist(), strict=True
            )
        },
        "start": tuned.start,
        "overall": tuned.overall,
        "held_out": tuned.held_out,
        "folds": [
            {
                "held_out_drives": list(fold.held),
                "train": fold.train,
                "held_out": fold.held_out,
                "IDSW": fold.switches,
                "weights": [weight / WEIGHT_SUM for weight in fold.weights],
                "shares": dict(zip(TRAITS, shares, strict=True)),
            }
            for fold, shares in zip(tuned.folds, tuned.balance.tolist(), strict=True)
        ],
    }
