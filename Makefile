# One command an action; CI runs the same ones.
UV_VERSION := 0.13.9
UV := .uv/bin/uv
RUN := .venv/bin/python -m
READY := .venv/.ready

.PHONY: demo test lint format bench gallery clean

demo: $(READY)
	$(RUN) bcifs.demo

test: $(READY)
	$(RUN) pytest -n auto --dist worksteal

lint: $(READY)
	$(RUN) ruff check .
	$(RUN) ruff format --check .
	$(RUN) pyright
	.venv/bin/lint-imports --no-logo

format: $(READY)
	$(RUN) ruff check --fix .
	$(RUN) ruff format .

bench: $(READY) | $(UV)
	$(UV) sync --frozen --inexact --group bench
	$(RUN) bench

gallery: $(READY)
	$(RUN) gallery

clean:
	rm -rf .uv .venv out

# The environment: uv itself goes into .uv (never into the system's Python), everything else into .venv.
$(READY): uv.lock pyproject.toml | $(UV)
	$(UV) sync --frozen --python python3
	@touch $@

$(UV):
	@python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "bcifs needs Python 3.11 or newer; python3 is `python3 --version`"; exit 1; }
	@{ python3 -m venv .uv && .uv/bin/python -m pip install -q uv==$(UV_VERSION); } \
	  || { rm -rf .uv && python3 -m pip install -q --target .uv uv==$(UV_VERSION); } \
	  || { echo "could not install uv into .uv: install uv $(UV_VERSION) yourself and run: make UV=\`which uv\`"; exit 1; }
