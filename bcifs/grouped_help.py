"""Help that shows the options of a command in groups."""

from typing import Any

from typer.core import TyperCommand


class Grouped(TyperCommand):
    """A command whose help has a section for each `rich_help_panel` of its options, in their order."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments, the options that belong to no group, and then group after group."""
        groups: dict[str, list[tuple[str, str]]] = {"Arguments": [], "Options": []}
        for parameter in self.get_params(ctx):
            kind = "Arguments" if parameter.param_type_name == "argument" else "Options"
            record = parameter.get_help_record(ctx)
            if record is not None:
                groups.setdefault(getattr(parameter, "rich_help_panel", None) or kind, []).append(record)
        for name, records in groups.items():
            if records:
                with formatter.section(name):
                    formatter.write_dl(records)
