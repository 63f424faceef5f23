"""What a filter author imports: parameters, filter, registry. Knows neither algorithms nor pymeshlab."""
