"""One self-contained HTML page of everything a results folder holds."""

from eval.report.build import ReportConfig, build_report

__all__ = ["ReportConfig", "build_report"]
