"""What is wrong with a page, and how much of it was compared."""


class Findings:
    """Differences from the results, and console messages and requests."""

    class Stop(Exception):
        """Something is wrong, and only the first such thing was wanted."""

    def __init__(self, first):
        self.first, self.wrong, self.trouble, self.compared = first, [], [], 0

    def listen(self, page, address, inner=("data:",)):
        """Opens the address; errors and warnings of its console, and every request that does not begin with `inner`, are trouble."""
        page.on("console", lambda m: m.type in ("error", "warning") and self.trouble.append(f"console: {m.text}"))
        page.on("pageerror", lambda error: self.trouble.append(f"script: {error}"))
        asked = lambda request: request.url != address and not request.url.startswith(inner)
        page.on("request", lambda request: asked(request) and self.trouble.append(f"request: {request.url}"))
        page.goto(address)
        self.check()

    def check(self):
        if self.first and (self.wrong or self.trouble):
            raise Findings.Stop

    def report(self):
        """Prints them; the exit code."""
        for line in (self.trouble + self.wrong)[:20]:
            print(line)
        print(f"{self.compared} readings compared, {len(self.wrong)} wrong; {len(self.trouble)} console messages and requests")
        return 1 if self.trouble or self.wrong else 0
